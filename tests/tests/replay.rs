//! Trials of a stored individual are played and taken away as they were.

use std::process::Command;

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

/// What the official reader of MCAP has to say of a file: messages a topic, and how often the goal was reached.
const READER: &str = "
import sys
from collections import Counter
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
with open(sys.argv[1], 'rb') as file:
    reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
    counts, goals, last, spheres = Counter(), 0, 0, 0
    for schema, channel, message, decoded in reader.iter_decoded_messages():
        assert message.log_time >= last, 'in order of time'
        last = message.log_time
        counts[channel.topic] += 1
        if schema.name == 'selftalk.Signals':
            goals += decoded.goal
            assert -3.2 < decoded.angle_l_elbow < 3.2 and (decoded.step == 0 or decoded.HasField('reward'))
        if schema.name == 'foxglove.SceneUpdate':
            spheres += sum(len(entity.spheres) for entity in decoded.entities)
    metadata = sorted(record.name for record in reader.iter_metadata())
    print(counts['/scene'], counts['/tf'], counts['/points'], counts['/signals'], goals, spheres > 0, *metadata, sep=',')
";

/// Python with the official reader, if there is one: that of SELFTALK_PYTHON, or of the system.
fn python() -> Option<std::ffi::OsString> {
    let python = std::env::var_os("SELFTALK_PYTHON").unwrap_or_else(|| "python3".into());
    let found = Command::new(&python).args(["-c", "import mcap.reader, mcap_protobuf.decoder"]).output();
    if found.is_ok_and(|output| output.status.success()) {
        return Some(python);
    }
    eprintln!("skipped: no Python with mcap and mcap-protobuf-support; SELFTALK_PYTHON may name one");
    None
}

#[test]
fn the_official_reader_reads_an_mcap_file() {
    let Some(python) = python() else { return };
    let place = Place::with_history(2);
    place.run("replay best --replication 0 --behaviour grasp --mcap grasp.mcap").done();
    let text = place.run("replay best --replication 0 --behaviour grasp --json -").done().stdout;
    let recordings: Vec<Value> = serde_json::from_str(&text).unwrap();
    let moments = || recordings.iter().flat_map(|recording| recording["moments"].as_array().unwrap());
    let goals = moments().filter(|moment| moment["step"]["goal"] == true).count();
    let output = Command::new(python).args(["-c", READER]).arg(place.path("grasp.mcap")).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let count = moments().count();
    let expected = format!("{count},{count},{count},{count},{goals},True,trial 10,trial 11,trial 8,trial 9");
    assert_eq!(String::from_utf8_lossy(&output.stdout).trim(), expected);
}

#[test]
fn key_moments_and_weights_are_drawn() {
    let place = Place::with_history(2);
    place.run("replay best --trial 9 --strip grasp.png").done();
    place.run("replay best --trial 9 --strip grasp.svg").done();
    place.run("show best --replication 0 --weights --image weights.png").done();
    for name in ["grasp.png", "weights.png"] {
        assert!(place.read(name).starts_with(b"\x89PNG"), "{name}");
    }
    let svg = String::from_utf8(place.read("grasp.svg")).unwrap();
    assert!(svg.contains("trial 9: grasp") && svg.contains("hears grasp"), "{svg}");
    let weights = place.ask("show best --replication 0 --weights");
    assert_eq!(weights.len(), 15 * (25 + 2) + 13 * (15 + 1));
    for (words, expected) in [
        ("replay best --trial 9 --strip grasp.jpg", "ends with .png or .svg"),
        ("replay best --strip grasp.png", "choose it with --trial, 0 to 15"),
        ("show best --weights --image weights.png", "--image draws one individual and these are 2"),
    ] {
        let message = place.run(words).refused(2);
        assert!(message.contains(expected), "{words}: {message}");
    }
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
