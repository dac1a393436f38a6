//! Looking after a master over the network.

use std::thread::sleep;
use std::time::Duration;

use selftalk_tests::{GOLDEN, Place, Running, wait_until, worker};
use serde_json::Value;

const WORKERS: &str = "workers-token-0123456789";
const OPERATORS: &str = "operators-token-0123456789";

fn place() -> Place {
    let place = Place::new();
    place.write("workers", WORKERS);
    place.write("operators", OPERATORS);
    place
}

const SERVE: &str =
    "serve --listen 127.0.0.1:0 --token-file workers --operator-token-file operators small.toml";

fn join(place: &Place, address: &str, token: &str) -> Running {
    let mut command = worker();
    command.current_dir(place.path("")).args(["--slots", "1", "--token-file", token]);
    command.args(["--master", &format!("http://{address}")]);
    Running::start(command)
}

/// What `selftalk operate` says to the master at an address.
fn operate(what: &str, address: &str) -> String {
    format!("operate {what} --master http://{address} --token-file operators")
}

fn generations(place: &Place, address: &str) -> u64 {
    let standings = place.ask(&operate("standings", address));
    standings.iter().map(|of| of["generations"].as_u64().unwrap()).sum()
}

#[test]
fn workers_and_operators_have_rights_of_their_own() {
    let place = place();
    let mut master = place.start(SERVE);
    let address = master.address();
    for what in ["standings", "workers", "pause", "continue", "stop"] {
        let words = operate(what, &address).replace("operators", "workers");
        let message = place.run(&words).failed(5);
        assert!(message.contains("refused: this master asks for its operators' token"), "{message}");
    }
    let message = join(&place, &address, "operators").end().failed(5);
    assert!(message.contains("refused: this master asks for a token"), "{message}");
    place.run(&format!("operate stop --master http://{address}")).refused(2);
    assert!(master.is_running());
    assert_eq!(generations(&place, &address), 0);
    let standings = place.ask(&operate("standings", &address));
    assert_eq!((&standings[0]["state"], &standings[0]["best_fitness"]), (&"running".into(), &Value::Null));

    let worker = join(&place, &address, "workers");
    let outcome = master.end().done();
    worker.end().done();
    assert!(
        !outcome.stderr.contains(OPERATORS) && !outcome.stderr.contains(WORKERS),
        "a token is never shown"
    );
    assert_eq!(place.digests(), GOLDEN);
}

#[test]
fn a_run_that_is_held_up_goes_on_where_it_was() {
    let place = place();
    let mut master = place.start(SERVE);
    let address = master.address();
    place.run(&operate("pause", &address)).done();
    let worker = join(&place, &address, "workers");
    let seen = wait_until("the worker", || {
        let workers = place.ask(&operate("workers", &address));
        workers.first().cloned()
    });
    assert_eq!((&seen["slots"], &seen["units"]), (&1.into(), &0.into()));
    sleep(Duration::from_secs(1));
    assert_eq!(generations(&place, &address), 0, "nothing is given out");
    assert_eq!(place.ask(&operate("standings", &address))[0]["state"], "paused");
    place.run(&operate("continue", &address)).done();
    master.end().done();
    worker.end().done();
    assert_eq!(place.digests(), GOLDEN);
}

#[test]
fn a_master_that_an_operator_has_ended_is_resumed_like_any_other() {
    let place = place();
    let mut master = place.start(SERVE);
    let address = master.address();
    let worker = join(&place, &address, "workers");
    wait_until("a generation", || (generations(&place, &address) > 0).then_some(()));
    place.run(&operate("stop", &address)).done();
    let message = master.end().failed(143);
    assert!(message.contains("interrupted; all complete generations are kept"), "{message}");
    drop(worker);
    place.run("resume").done();
    assert_eq!(place.digests(), GOLDEN);
}

#[test]
fn operators_are_encrypted_and_certified_like_workers() {
    let place = Place::new();
    place.run("keys init keys").done();
    let mut master = place.start("serve --listen 127.0.0.1:0 --keys keys/master small.toml");
    let at = format!("--master https://{} --keys", master.address());
    place.run(&format!("operate standings {at} keys/operator")).done();
    let message = place.run(&format!("operate standings {at} keys/worker")).failed(5);
    assert!(message.contains("asks for its operators' token"), "{message}");
    place.run("keys init others").done();
    let message = place.run(&format!("operate standings {at} others/operator")).failed(5);
    assert!(message.contains("no master reached") || message.contains("transport"), "{message}");
    assert!(master.is_running());
}

#[test]
fn what_gives_nobody_rights_is_said() {
    let place = place();
    let mut master = place.start("serve --listen 127.0.0.1:0 --token-file workers small.toml");
    let message = place.run(&operate("stop", &master.address())).failed(5);
    assert!(message.contains("was started without --operator-token-file"), "{message}");
    drop(master);
    let same = "serve --token-file workers --operator-token-file workers small.toml --db other.db";
    let message = place.run(same).refused(2);
    assert!(message.contains("workers and operators have the same token"), "{message}");
    let message = place.run(&operate("stop", "127.0.0.1:1")).failed(5);
    assert!(message.starts_with("http://127.0.0.1:1: no master reached"), "{message}");
    let message = place.run("operate stop --master nowhere --token-file operators").refused(2);
    assert!(message.contains("expected http://HOST:PORT"), "{message}");
}
