//! Lines between machines that are encrypted, and who is let in.

use selftalk_tests::{GOLDEN, Place, Running, worker};

/// A worker with the keys in a folder, for a master at an address.
fn worker_with(place: &Place, address: &str, keys: &str) -> Running {
    let mut command = worker();
    command.current_dir(place.path("")).args(["--slots", "1", "--connect-timeout", "1"]);
    command.args(["--master", &format!("https://{address}"), "--keys", keys]);
    Running::start(command)
}

#[test]
fn only_workers_that_belong_to_the_master_are_let_in() {
    let place = Place::new();
    place.run("keys init keys").done();
    place.run("keys init others").done();
    std::fs::create_dir(place.path("nameless")).unwrap();
    for name in ["ca.crt", "token"] {
        place.write(&format!("nameless/{name}"), place.read(&format!("keys/worker/{name}")));
    }
    std::fs::create_dir(place.path("stranger")).unwrap();
    for name in ["ca.crt", "tls.crt", "tls.key"] {
        place.write(&format!("stranger/{name}"), place.read(&format!("keys/worker/{name}")));
    }
    place.write("stranger/token", place.read("others/worker/token"));

    let mut master = place.start("serve --listen 127.0.0.1:0 --keys keys/master small.toml");
    let address = master.address();
    assert!(master.reported().contains(&format!("--master https://{address} --keys FOLDER")));
    for (keys, word) in [
        ("others/worker", "no master reached within 1 s"),
        ("nameless", "no master reached within 1 s"),
        ("stranger", "asks for a token"),
    ] {
        let message = worker_with(&place, &address, keys).end().failed(5);
        assert!(message.contains(word), "{keys}: {message}");
    }
    let mut open = worker();
    open.args(["--connect-timeout", "1", "--master", &format!("http://{address}")]);
    Running::start(open).end().failed(5);

    let admitted = worker_with(&place, &address, "keys/worker");
    let reported = master.end().done().stderr;
    admitted.end().done();
    assert_eq!(place.digests(), GOLDEN);
    let token = String::from_utf8(place.read("keys/master/token")).unwrap();
    assert!(!reported.contains(token.trim()), "a token is never shown");
}

#[test]
fn with_keys_a_master_listens_to_other_machines() {
    let place = Place::new();
    place.run("keys init keys --host master.example --host 192.0.2.7").done();
    let mut master = place.start("serve --listen 0.0.0.0:0 --keys keys/master small.toml");
    assert!(master.address().starts_with("0.0.0.0:"));
    drop(master);
    std::fs::remove_file(place.path("keys/master/token")).unwrap();
    let message = place.run("serve --listen 0.0.0.0:0 --keys keys/master small.toml").refused(2);
    assert!(message.contains("other machines could join as workers, as no token is asked for"), "{message}");
}

#[test]
fn keys_that_cannot_be_used_are_said_to_be() {
    let place = Place::new();
    let message = place.run("serve --keys nowhere small.toml").refused(2);
    assert!(message.starts_with("nowhere/tls.crt: cannot be read"), "{message}");
    assert!(message.contains("`selftalk keys init` makes such folders"), "{message}");
    let message = worker_with(&place, "127.0.0.1:1", "nowhere").end().failed(2);
    assert!(message.starts_with("nowhere/ca.crt: cannot be read"), "{message}");
    let message = place.run("keys init keys --host no,name").refused(2);
    assert!(message.starts_with("--host no,name: expected a host name or an IP address"), "{message}");
    assert!(!place.path("keys").exists());
    place.run("keys init keys").done();
    let before = place.read("keys/master/tls.key");
    let message = place.run("keys init keys").refused(2);
    assert!(message.starts_with("keys: ") && message.contains("choose a folder that does not"), "{message}");
    assert_eq!(place.read("keys/master/tls.key"), before);
    let mut open = worker();
    open.current_dir(place.path("")).args(["--master", "http://127.0.0.1:1", "--keys", "keys/worker"]);
    let message = Running::start(open).end().failed(2);
    assert!(message.contains("expected https://HOST:PORT, as keys are given"), "{message}");
}

#[cfg(unix)]
#[test]
fn nobody_else_can_read_the_keys() {
    use std::os::unix::fs::PermissionsExt;

    let place = Place::new();
    place.run("keys init keys").done();
    let mut folders = vec![place.path("keys")];
    let mut files = 0;
    while let Some(folder) = folders.pop() {
        assert_eq!(folder.metadata().unwrap().permissions().mode() & 0o777, 0o700, "{}", folder.display());
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                files += 1;
                assert_eq!(
                    path.metadata().unwrap().permissions().mode() & 0o777,
                    0o600,
                    "{}",
                    path.display()
                );
            }
        }
    }
    assert_eq!(files, 15);
}
