//! History files that are not what they should be: one line, exit code 4, and nothing is made worse.

use selftalk_tests::{GOLDEN, Outcome, Place};

const READERS: [&str; 4] = ["history experiments", "history individuals --genes", "verify", "digest"];
const WRITERS: [&str; 3] = ["run small.toml", "resume", "serve --listen 127.0.0.1:0"];

/// A finished history of two generations.
fn finished() -> Place {
    let place = Place::new();
    place.run("run small.toml --set generations=2").done();
    assert!(!place.path("history.db-wal").exists(), "a master that ends leaves one file");
    place
}

/// Makes sure that a command refuses the file, saying so in these words.
#[track_caller]
fn refused(outcome: Outcome, words: &[&str]) {
    let message = outcome.refused(4);
    assert!(message.contains("history.db: "), "{message}");
    assert!(words.iter().any(|words| message.contains(words)), "{message}");
}

#[test]
fn a_missing_file_is_not_created_by_a_question() {
    let place = Place::new();
    for command in READERS.into_iter().chain(["resume", "serve --listen 127.0.0.1:0"]) {
        refused(place.run(command), &["no such file"]);
    }
    assert!(!place.path("history.db").exists());
}

#[test]
fn a_folder_that_does_not_exist_is_not_created() {
    let place = Place::new();
    let message = place.run("run small.toml --db nowhere/a.db").refused(4);
    assert!(message.contains("nowhere/a.db: the folder does not exist"), "{message}");
    assert!(!place.path("nowhere").exists());
}

#[test]
fn other_programs_files_are_left_alone() {
    let place = finished();
    // Where SQLite keeps whose database it is.
    let mut foreign = place.read("history.db");
    foreign[68..72].copy_from_slice(b"mine");
    let text = b"Dear diary, today I evolved a robot. ".repeat(300);
    for content in [&foreign, &text] {
        place.write("history.db", content);
        for command in READERS.into_iter().chain(WRITERS) {
            refused(place.run(command), &["not a selftalk history"]);
        }
        assert!(place.read("history.db") == *content);
    }
}

#[test]
fn a_damaged_file_is_found_out() {
    let place = finished();
    let sound = place.read("history.db");
    let page = usize::from(u16::from_be_bytes([sound[16], sound[17]]));
    assert!(page >= 512 && sound.len() > 8 * page);
    let mut schema = sound.clone();
    schema[100..page].fill(0x55);
    let mut data = sound.clone();
    data[page..].fill(0xaa);
    for (name, content) in [("schema", &schema), ("data", &data)] {
        place.write("history.db", content);
        for command in READERS.into_iter().chain(["run small.toml --set generations=2", "resume"]) {
            let outcome = place.run(command);
            assert_eq!(outcome.code, Some(4), "{name}: {command}: {outcome:?}");
            refused(outcome, &["damaged", "not a selftalk history"]);
        }
        assert!(place.read("history.db") == *content, "{name}");
    }
    place.write("history.db", sound);
    place.run("digest").done();
}

#[test]
fn a_truncated_file_is_found_out() {
    let place = finished();
    let sound = place.read("history.db");
    let page = usize::from(u16::from_be_bytes([sound[16], sound[17]]));
    let pages = sound.len() / page;
    for length in [50, page, page * pages / 2, page * pages / 2 + 100, page * (pages - 1), sound.len() - 1] {
        let content = &sound[..length];
        place.write("history.db", content);
        for command in READERS.into_iter().chain(["resume"]) {
            let outcome = place.run(command);
            assert_eq!(outcome.code, Some(4), "{length}: {command}: {outcome:?}");
            refused(outcome, &["damaged", "not a selftalk history"]);
        }
        assert!(place.read("history.db") == content, "{length}");
    }
    // An empty file is as good as none for a run, and is no history yet.
    place.write("history.db", "");
    refused(place.run("history experiments"), &["the file is empty"]);
    place.run("run small.toml --set generations=1").done();
}

#[test]
fn a_second_master_is_refused_and_does_no_harm() {
    let place = Place::new();
    let mut first = place.start("serve --listen 127.0.0.1:0 small.toml");
    let address = first.address();
    for command in WRITERS.into_iter().chain(["run quickstart"]) {
        let message = place.run(command).refused(4);
        assert!(message.contains(&format!("another selftalk master (process {})", first.id())), "{message}");
    }
    place.run("history experiments").done();
    let worker = place.start_worker(&address);
    first.end().done();
    worker.end().done();
    assert_eq!(place.digests(), GOLDEN);
    assert_eq!(place.ask("history experiments").len(), 1);
}
