//! Experiments, ports and masters that are not what they should be: one line, and the documented exit code.

use std::io::{Read, Write};
use std::net::TcpListener;
use std::process::Command;
use std::time::Instant;

use selftalk_tests::{Outcome, Place, Running, free_port, worker};

#[test]
fn bad_experiment_files_name_the_key_and_what_is_possible() {
    let place = Place::new();
    let cases = [
        ("sede = 3", &["bad.toml", "sede", "`seed`"][..]),
        ("[evolution]\npopulatoin = 20", &["evolution.populatoin", "`population`"]),
        ("generations = \"many\"", &["generations", "string"]),
        ("[reach]\nsteps = 2.5", &["reach.steps"]),
        ("generations = 0", &["generations = 0", "between 1 and"]),
        ("[evolution]\nmutation = 1.5", &["evolution.mutation = 1.5", "between 0 and 1"]),
        ("[evolution]\nparents = 7", &["evolution.offspring", "parents x offspring"]),
        ("name = \"two words\"", &["name", "letters"]),
        ("seed = 1\nname = ", &["line 2"]),
        ("seed = 1\nseed = 2", &["line 2"]),
        ("engine = \"unreal\"", &["engine", "`lockstep`", "`rapier`"]),
    ];
    for (text, words) in cases {
        place.write("bad.toml", text);
        for command in ["run bad.toml", "serve --listen 127.0.0.1:0 bad.toml"] {
            let message = place.run(command).refused(3);
            assert!(message.starts_with("bad.toml: "), "{message}");
            for word in words {
                assert!(message.contains(word), "{text}: {word}: {message}");
            }
        }
    }
    place.write("bad.toml", b"name = \"\xff\xfe\"");
    let message = place.run("run bad.toml").refused(3);
    assert!(message.contains("bad.toml: cannot be read"), "{message}");
    place.run("run .").refused(3);
    let message = place.run("run missing.toml").refused(2);
    assert!(message.contains("missing.toml: neither a file nor a preset (presets: quickstart"), "{message}");
    assert!(!place.path("history.db").exists());
}

#[test]
fn bad_overrides_are_refused() {
    let place = Place::new();
    for (set, word) in [
        ("generations", "expected key=value"),
        ("=3", "the key is empty"),
        ("sede=3", "`seed`"),
        ("evolution.mutation=much", "evolution.mutation"),
        ("seed.more=3", "below a value"),
        ("replications=0", "between 1 and"),
        ("seed=-1", "seed"),
    ] {
        let message = place.run(&format!("run small.toml --set {set}")).refused(3);
        assert!(message.contains(word), "{set}: {message}");
    }
    assert!(!place.path("history.db").exists());
}

#[test]
fn other_settings_under_the_same_name_are_refused() {
    let place = Place::new();
    place.run("run small.toml --set generations=1").done();
    let before = place.digests();
    let message = place.run("run small.toml").refused(6);
    assert!(message.contains("`small` exists with other settings (generations is 1, not 12)"), "{message}");
    assert!(message.contains("--set name=..."), "{message}");
    place.run("run small.toml --set generations=1 --set name=other --seed 3").done();
    assert_eq!(place.digests(), before);
    assert_eq!(place.ask("history experiments").len(), 2);
}

#[test]
fn a_taken_port_is_said_before_anything_is_written() {
    let place = Place::new();
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap();
    let message = place.run(&format!("serve --listen {address} small.toml")).refused(5);
    assert!(message.starts_with(&format!("{address}: cannot listen: ")), "{message}");
    let message = place.run("serve --insecure --listen 192.0.2.1:7700 small.toml").refused(5);
    assert!(message.contains("cannot listen"), "{message}");
    assert!(!place.path("history.db").exists());
}

/// A worker that is not patient, for whatever is at this address.
fn impatient(master: &str) -> Command {
    let mut command = worker();
    command.args(["--slots", "1", "--connect-timeout", "1", "--master", master]);
    command
}

fn run(command: Command) -> Outcome {
    Running::start(command).end()
}

#[test]
fn an_unreachable_master_is_given_up() {
    let address = format!("127.0.0.1:{}", free_port());
    let begin = Instant::now();
    let message = run(impatient(&format!("http://{address}"))).failed(5);
    assert!(message.starts_with(&format!("http://{address}: no master reached within 1 s: ")), "{message}");
    assert!(begin.elapsed().as_secs() >= 1);
}

#[test]
fn a_master_that_does_not_answer_is_given_up() {
    // The system accepts the connection, and nobody reads from it.
    let silent = TcpListener::bind("127.0.0.1:0").unwrap();
    let begin = Instant::now();
    let message = run(impatient(&format!("http://{}", silent.local_addr().unwrap()))).failed(5);
    assert!(message.contains("no master reached") && message.ends_with("does not answer"), "{message}");
    let seconds = begin.elapsed().as_secs_f64();
    assert!((1.0..4.5).contains(&seconds), "{seconds}");
}

#[test]
fn something_else_at_the_masters_address_is_said_to_be() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    // A web server that has nothing to offer, until the test's process ends.
    std::thread::spawn(move || {
        for stream in listener.incoming() {
            let mut stream = stream.unwrap();
            let _ = stream.read(&mut [0; 1024]);
            let _ =
                stream.write_all(b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\nConnection: close\r\n\r\n");
        }
    });
    let message = run(impatient(&format!("http://{address}"))).failed(5);
    assert!(message.starts_with(&format!("http://{address}: no master reached")), "{message}");
}
