//! Who may work for a master.

use selftalk_tests::{GOLDEN, Place, Running, worker};

const TOKEN: &str = "7e0b1c52d9c84f6aa1b2c3d4e5f60718";

/// A worker for a master, with a token in a file, in the environment, or nowhere.
fn worker_with(place: &Place, address: &str, file: Option<&str>, variable: Option<&str>) -> Running {
    let mut command = worker();
    command.current_dir(place.path("")).args(["--slots", "1", "--master", &format!("http://{address}")]);
    command.env_remove("SELFTALK_TOKEN");
    if let Some(variable) = variable {
        command.env("SELFTALK_TOKEN", variable);
    }
    command.args(file.map(|file| ["--token-file", file]).into_iter().flatten());
    Running::start(command)
}

#[test]
fn a_master_with_a_token_takes_in_only_those_who_have_it() {
    let place = Place::new();
    place.write("token", format!("{TOKEN}\n"));
    place.write("other", "another-token-of-some-length");
    let mut master = place.start("serve --listen 127.0.0.1:0 --token-file token small.toml");
    let address = master.address();
    for (file, variable) in [(None, None), (Some("other"), None), (None, Some("another-token-of-length"))] {
        let message = worker_with(&place, &address, file, variable).end().failed(5);
        assert!(message.contains("refused: this master asks for a token"), "{message}");
        assert!(message.contains("--token-file or SELFTALK_TOKEN"), "{message}");
    }
    let by_file = worker_with(&place, &address, Some("token"), None);
    let by_variable = worker_with(&place, &address, None, Some(TOKEN));
    let outcome = master.end().done();
    assert!(!outcome.stderr.contains(TOKEN), "a token is never shown");
    by_file.end().done();
    by_variable.end().done();
    assert_eq!(place.digests(), GOLDEN);
}

#[test]
fn tokens_that_cannot_be_used_are_said_to_be() {
    let place = Place::new();
    place.write("short", "1234");
    let message = place.run("serve --token-file short small.toml").refused(2);
    assert!(message.starts_with("short: a token has 16 to 512 visible ASCII characters"), "{message}");
    let message = place.run("serve --token-file nowhere small.toml").refused(2);
    assert!(message.starts_with("nowhere: the token cannot be read"), "{message}");
    let message = worker_with(&place, "127.0.0.1:1", Some("short"), None).end().failed(2);
    assert!(message.starts_with("short: a token has"), "{message}");
}

#[test]
fn other_machines_are_let_in_only_on_purpose() {
    let place = Place::new();
    place.write("token", TOKEN);
    let message = place.run("serve --listen 0.0.0.0:0 small.toml").refused(2);
    assert!(
        message.contains("other machines could join as workers") && message.contains("--insecure"),
        "{message}"
    );
    let message = place.run("serve --listen 0.0.0.0:0 --token-file token small.toml").refused(2);
    assert!(message.contains("other machines could read along"), "{message}");
    assert!(!place.path("history.db").exists());
    let mut master = place.start("serve --listen 0.0.0.0:0 --insecure small.toml");
    assert!(master.address().starts_with("0.0.0.0:"));
}
