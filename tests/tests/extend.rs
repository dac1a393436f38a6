//! Experiments that are given more generations.

use selftalk_tests::{GOLDEN, Place};

#[test]
fn an_extended_experiment_comes_to_what_a_longer_one_does() {
    let place = Place::with_history(5);
    let replications = place.ask("extend small --generations 12");
    assert_eq!(replications.len(), 2);
    for replication in replications {
        assert_eq!((&replication["state"], &replication["planned"]), (&"running".into(), &12.into()));
        assert_eq!(replication["generations"], 5);
    }
    place.run("resume").done();
    assert_eq!(place.digests(), GOLDEN);
    // It is what that file describes.
    let again = place.run("run small.toml").done();
    assert!(again.stderr.contains("finished already"), "{}", again.stderr);
    place.run("verify --best").done();
}

#[test]
fn what_is_not_longer_or_not_there_is_refused_and_changes_nothing() {
    let place = Place::with_history(2);
    let before = place.ask("history replications");
    for (words, code, part) in [
        ("extend small --generations 2", 2, "`small` has 2 already"),
        ("extend small --generations 1", 2, "`small` has 2 already"),
        ("extend large --generations 5", 2, "there is: small"),
        ("extend small --generations 5 --db none.db", 4, "none.db"),
    ] {
        let message = place.run(words).refused(code);
        assert!(message.contains(part), "{words}: {message}");
    }
    assert_eq!(place.ask("history replications"), before);
    assert!(!place.path("none.db").exists());
}

#[test]
fn a_running_experiment_is_left_to_its_master() {
    let place = Place::new();
    let mut master = place.start("serve --listen 127.0.0.1:0 --dashboard off small.toml");
    // When it has one, it has the database.
    let _address = master.address();
    let message = place.run("extend small --generations 20").refused(4);
    assert!(message.contains("process"), "{message}");
}
