//! The whole study as one command: what it writes, and that it comes to the same however often it was killed.

use std::collections::BTreeMap;
use std::fs;
use std::time::Duration;

use selftalk_tests::Place;

/// A study of a few seconds: small populations, few generations, short trials.
/// Of the first phase there are two parts.
fn command() -> String {
    let all = [
        "replications=2",
        "evolution.population=10",
        "evolution.parents=2",
        "physics.substeps=4",
        "reach.steps=6",
        "open.steps=6",
        "grasp.steps=6",
        "move.steps=6",
        "move_to_target.steps=10",
    ];
    let all: String = all.iter().map(|setting| format!(" --set {setting}")).collect();
    let first = "--first elementary-0.5 --first elementary-further --set-first generations=6";
    format!("reproduce --dir study --workers 2{all} {first} --set-second generations=6")
}

/// What a study has written that must not depend on how the run went: all files but figures' pixels and the workers.
fn written(place: &Place) -> BTreeMap<String, String> {
    let mut files = BTreeMap::new();
    for folder in ["study/report", "study/elementary-0.5", "study/elementary-further"] {
        for entry in fs::read_dir(place.path(folder)).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_str().unwrap().to_owned();
            if !name.ends_with(".png") && name != "workers.csv" {
                files.insert(format!("{folder}/{name}"), fs::read_to_string(path).unwrap());
            }
        }
    }
    files
}

/// Numbers that look random and are the same each time (Lehmer, 1951).
fn delays() -> impl Iterator<Item = Duration> {
    let next = |state: &u64| Some(state * 48_271 % 2_147_483_647);
    std::iter::successors(Some(7), next).skip(1).map(|number| Duration::from_millis(200 + number % 1800))
}

#[test]
fn a_study_is_the_same_however_often_it_was_killed() {
    let undisturbed = Place::new();
    undisturbed.run(&command()).done();
    let expected = written(&undisturbed);
    let summary = &expected["study/report/summary.csv"];
    for condition in ["C", "LE", "ST", "LST"] {
        let robots = summary.lines().filter(|line| line.starts_with(&format!("{condition},"))).count();
        assert_eq!(robots, 2, "{summary}");
    }
    let page = &expected["study/report/report.md"];
    assert!(page.contains("| LST | 2 |") && page.contains("Own labels and the caretaker's"), "{page}");
    assert_eq!(expected["study/report/pairwise.csv"].lines().count(), 1 + 2 * 6);
    assert_eq!(expected["study/elementary-0.5/summary.csv"].lines().count(), 1 + 2);
    assert!(expected["study/report/linked-lst.toml"].contains("anticipation_share = 0.2"));
    let further = &expected["study/elementary-further/experiment.toml"];
    for line in expected["study/elementary-0.5/best.csv"].lines().skip(1) {
        let genes = line.rsplit(',').next().unwrap();
        assert!(further.contains(genes), "{line}");
    }

    let place = Place::new();
    let mut kills = 0;
    for delay in delays().take(10) {
        let run = place.start(&command());
        std::thread::sleep(delay);
        kills += u32::from(run.kill());
    }
    assert!(kills > 2, "only {kills} kills came in time");
    place.run(&command()).done();
    assert_eq!(written(&place), expected);
    // There is nothing left to do, and what is written stays.
    let again = place.run(&command()).done();
    assert!(!again.stderr.contains("evolution of"), "{again:?}");
    assert_eq!(written(&place), expected);
}

#[cfg(unix)]
#[test]
fn an_interrupted_study_says_how_to_go_on() {
    let place = Place::new();
    let mut run = place.start(&command());
    assert!(run.reports("evolution of"));
    run.signal(rustix::process::Signal::TERM);
    let message = run.end().failed(143);
    assert!(
        message.starts_with("interrupted; ") && message.contains("the same command goes on"),
        "{message}"
    );
}

#[test]
fn another_study_is_not_mixed_in() {
    let place = Place::new();
    let short = command().replace("generations=6", "generations=1");
    place.run(&short).done();
    let message = place.run(&format!("{short} --seed 9")).refused(6);
    assert!(message.contains("seed is 1, not 9"), "{message}");
    let message = place.run("reproduce --dir other --first integrated-c").refused(2);
    assert!(message.contains("not an experiment of the first phase"), "{message}");
    let message = place.run("reproduce --dir other --first elementary --first elementary-linked").refused(2);
    assert!(message.contains("ancestors.evolve = true"), "{message}");
    let message = place.run("reproduce --dir other --first elementary-further").refused(2);
    assert!(message.contains("has to come before it"), "{message}");
}
