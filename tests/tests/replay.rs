//! Trials of a stored individual are played and taken away as they were.

// Helpers of tests are test code as well, though the compiler cannot know it.
#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used)]

use selftalk_tests::Place;
use serde_json::Value;

#[test]
fn a_stored_trial_is_taken_away_with_all_its_signals() {
    let place = Place::with_history(3);
    let best = &place.ask("history individuals --best --replication 1")[0];
    let name = format!("small/1/{}/{}", best["generation"], best["individual"]);
    let trials = place.ask(&format!("show {name}"));

    let text = place.run(&format!("replay {name} --json -")).done().stdout;
    let recordings: Vec<Value> = serde_json::from_str(&text).unwrap();
    assert_eq!(recordings.len(), 16);
    for (recording, trial) in recordings.iter().zip(&trials) {
        assert_eq!((&recording["score"], &recording["success"]), (&trial["score"], &trial["success"]));
        let moments = recording["moments"].as_array().unwrap();
        assert_eq!(moments.len() as u64, 1 + trial["steps"].as_u64().unwrap(), "the start, and every step");
    }

    let csv = place.run("replay --replication 1 --trial 9 --csv -").done().stdout;
    assert_eq!(csv.lines().count() as u64, 2 + trials[9]["steps"].as_u64().unwrap());
    assert!(csv.starts_with("time,object_x,"), "{csv}");

    place.run("replay best --replication 1 --behaviour grasp --html grasp.html").done();
    let page = String::from_utf8(place.read("grasp.html")).unwrap();
    assert_eq!(page.matches("\"behaviour\":\"grasp\"").count(), 4);
    assert!(page.contains(&name));
}

#[test]
fn what_is_not_there_is_not_replayed() {
    let place = Place::with_history(1);
    for (words, expected) in [
        ("replay small/0/9/0", "there is no generation 9"),
        ("replay --trial 16", "there is no trial 16; they go from 0 to 15"),
        ("replay --behaviour push", "the behaviours are: reach, open, grasp, move"),
        ("replay --csv -", "choose it with --trial, 0 to 15"),
    ] {
        let message = place.run(words).refused(2);
        assert!(message.contains(expected), "{words}: {message}");
    }
}
