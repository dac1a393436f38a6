//! Ctrl-C and SIGTERM: a clean end, the right exit code, and the way to go on.

#![cfg(unix)]

use rustix::process::Signal;
use selftalk_tests::{GOLDEN, Outcome, Place, free_port, wait_until};

/// A run that got this signal in its middle, and what it came to.
fn interrupted(command: &str, signal: Signal) -> (Place, Outcome) {
    let mut outcome = None;
    let place = Place::disturbed(|place| {
        let mut run = place.start(command);
        place.wait_half_way();
        run.signal(signal);
        outcome = Some(run.end());
        place.is_half_way()
    });
    (place, outcome.unwrap())
}

#[test]
fn a_run_ends_on_ctrl_c_says_how_to_go_on_and_goes_on() {
    let (place, outcome) = interrupted("run small.toml --workers 2", Signal::INT);
    assert_eq!(outcome.stdout, "");
    let message = outcome.failed(130);
    let resume = "`selftalk resume small --db history.db`";
    assert!(message.starts_with("interrupted; ") && message.contains(resume), "{message}");
    let log = std::fs::metadata(place.path("history.db-wal"));
    assert!(log.map_or(0, |log| log.len()) == 0, "everything is in the one file");
    let before = place.generations();
    assert!((2..24).contains(&before), "{before}");

    let message = place.run("run small.toml").refused(6);
    assert!(message.contains("`small` was interrupted") && message.contains(resume), "{message}");
    assert_eq!(place.generations(), before);

    let resumed = place.run("resume small --workers 2 --format json").objects();
    assert!(resumed.iter().all(|line| line["state"] == "finished"), "{resumed:?}");
    assert_eq!(place.digests(), GOLDEN);
}

#[test]
fn sigterm_has_its_own_exit_code() {
    let (place, outcome) = interrupted("run small.toml --workers 1", Signal::TERM);
    assert!(outcome.failed(143).starts_with("interrupted; "));
    assert!(place.generations() >= 2);
}

#[test]
fn a_finished_experiment_is_not_run_again() {
    let place = Place::new();
    let first = place.run("run small.toml --set generations=2 --format csv").done();
    let history = place.read("history.db");
    for command in ["run small.toml --set generations=2", "resume small", "resume"] {
        let again = place.run(&format!("{command} --format csv")).done();
        assert_eq!(again.stdout, first.stdout, "{command}");
        assert!(again.stderr.contains("finished"), "{again:?}");
    }
    assert!(place.read("history.db") == history, "nothing is written");
}

#[test]
fn a_master_without_workers_ends_on_ctrl_c() {
    let place = Place::new();
    let mut master = place.start("serve --listen 127.0.0.1:0 small.toml");
    let _ = master.address();
    master.signal(Signal::INT);
    let message = master.end().failed(130);
    assert!(message.contains("selftalk resume small"), "{message}");
    place.run("resume").done();
    assert_eq!(place.digests(), GOLDEN);
}

#[test]
fn a_worker_ends_on_ctrl_c_and_the_master_goes_on() {
    let place = Place::disturbed(|place| {
        let mut master = place.start("serve --listen 127.0.0.1:0 small.toml");
        let address = master.address();
        let mut first = place.start_worker(&address);
        place.wait_half_way();
        first.signal(Signal::INT);
        let outcome = first.end();
        if !place.is_half_way() {
            return false;
        }
        assert_eq!(outcome.code, Some(130), "{outcome:?}");
        wait_until("the master notes its leave", || {
            let workers = place.ask("history workers");
            assert_eq!(workers.len(), 1);
            workers[0]["left_at"].is_string().then_some(())
        });
        let second = place.start_worker(&address);
        master.end().done();
        second.end().done();
        true
    });
    assert_eq!(place.digests(), GOLDEN);
}

#[test]
fn a_worker_that_waits_for_its_master_ends_on_ctrl_c() {
    let place = Place::new();
    let mut worker = place.start_worker(&format!("127.0.0.1:{}", free_port()));
    assert!(worker.reports("not connected"));
    worker.signal(Signal::INT);
    assert_eq!(worker.end().code, Some(130));
}

#[test]
fn workers_outlive_a_master_that_is_interrupted() {
    let _place = Place::disturbed(|place| {
        let mut master = place.start("serve --listen 127.0.0.1:0 small.toml");
        let mut worker = place.start_worker(&master.address());
        place.wait_half_way();
        master.signal(Signal::INT);
        let outcome = master.end();
        if !place.is_half_way() {
            return false;
        }
        outcome.failed(130);
        assert!(worker.reports("not connected"));
        worker.is_running()
    });
}
