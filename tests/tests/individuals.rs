//! Looking at stored individuals: their trials again, and fresh ones.

// Helpers of tests are test code as well, though the compiler cannot know it.
#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used)]

use selftalk_tests::Place;
use serde_json::Value;
use sqlx::Connection;

const GENERATIONS: u64 = 5;

fn place() -> Place {
    let place = Place::new();
    place.run(&format!("run small.toml --set generations={GENERATIONS}")).done();
    place
}

/// Changes what is stored, as no master would.
fn tamper(place: &Place, statement: &'static str) {
    let path = place.path("history.db");
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        let options = sqlx::sqlite::SqliteConnectOptions::new().filename(path);
        let mut connection = sqlx::SqliteConnection::connect_with(&options).await.unwrap();
        let changed = sqlx::query(statement).execute(&mut connection).await.unwrap().rows_affected();
        assert!(changed > 0, "{statement}");
        connection.close().await.unwrap();
    });
}

fn name(line: &Value) -> String {
    let part = |key: &str| line[key].to_string();
    let experiment = line["experiment"].as_str().unwrap();
    format!("{experiment}/{}/{}/{}", part("replication"), part("generation"), part("individual"))
}

#[test]
fn trials_are_shown_with_what_went_wrong() {
    let place = place();
    let best = place.ask("history individuals --best");
    let shown = place.ask("show");
    assert_eq!(shown.len(), 2 * 16);
    for (best, trials) in best.iter().zip(shown.chunks(16)) {
        assert_eq!(name(&trials[0]), name(best));
        let successes = trials.iter().filter(|trial| trial["success"] == true).count() as u64;
        assert_eq!(best["successes"], successes);
        assert!(trials.iter().all(|trial| trial["fitness"] == best["fitness"]));
        assert_eq!((&trials[3]["behaviour"], &trials[4]["behaviour"]), (&"reach".into(), &"open".into()));
        for trial in trials {
            let reason = trial["reason"].as_str().unwrap();
            assert_eq!(reason.is_empty(), trial["success"] == true, "{trial}");
        }
    }
    // 8 steps are few: the hand gets nowhere.
    let reach =
        shown.iter().find(|trial| trial["behaviour"] == "reach" && trial["success"] == false).unwrap();
    let reason = reach["reason"].as_str().unwrap();
    assert!(
        reason.starts_with("nearest to the goal at step ") && reason.contains("palm to top 0."),
        "{reason}"
    );
    assert!(reason.contains("(goal 0.06; "), "{reason}");

    let individual = name(&best[1]);
    assert_eq!(place.ask(&format!("show {individual}")), shown[16..]);
    assert_eq!(place.ask(&format!("show {individual} best {individual}")).len(), 2 * 16);
    let table = place.run(&format!("show {individual}")).done().stdout;
    let parent = format!("small/1/{}/{}", GENERATIONS - 2, best[1]["parent"]);
    for part in [individual.as_str(), parent.as_str(), "behaviour", "nearest to the goal"] {
        assert!(table.contains(part), "{part}: {table}");
    }
    assert_eq!(place.ask("show best --replication 0 --generation 2").len(), 16);
    assert_eq!(place.ask("show champion --replication 0").len(), 16);
}

#[test]
fn what_does_not_come_out_again_is_said() {
    let place = place();
    let best = &place.ask("history individuals --best --replication 0")[0];
    tamper(
        &place,
        "UPDATE trial SET score = score + 1e-9 WHERE replication_id = 1 AND generation = 4 AND trial = 6",
    );
    let message = place.run("show --replication 0").refused(7);
    assert!(message.starts_with(&format!("{}: trial 6 comes to score ", name(best))), "{message}");
    tamper(&place, "UPDATE experiment SET fingerprint = 'another'");
    let message = place.run("show --replication 0").refused(7);
    assert!(message.contains("simulator that gives other results (fingerprint another,"), "{message}");
    let outcome = place.run("evaluate --replication 1 --trials 16").done();
    assert!(
        outcome.stderr.starts_with("warning: experiment `small` was run with a simulator"),
        "{outcome:?}"
    );
}

#[test]
fn fresh_trials_come_to_the_same_with_any_number_of_workers() {
    let place = place();
    let once = place.run("evaluate best --trials 64 --workers 1 --format csv").done().stdout;
    let again = place.run("evaluate best --trials 64 --workers 3 --format csv").done().stdout;
    assert_eq!(once, again);
    let lines = place.ask("evaluate best --trials 64");
    assert_eq!(lines.len(), 2);
    for line in &lines {
        assert_eq!(line["trials"], 64);
        let share = |key: &str| line[key].as_f64().unwrap();
        let mean = ["reach", "open", "grasp", "move"].map(share).iter().sum::<f64>() / 4.0;
        assert!((0.0..=1.0).contains(&mean) && (share("all") - mean).abs() < 1e-12, "{line}");
    }
    // Who it is does not depend on who else is named.
    let names: Vec<String> = lines.iter().rev().map(name).collect();
    let reversed: Vec<Value> = lines.iter().rev().cloned().collect();
    assert_eq!(place.ask(&format!("evaluate {} --trials 64", names.join(" "))), reversed);
    assert_eq!(place.ask("evaluate")[0]["trials"], 400);
    let champions = |workers| place.ask(&format!("evaluate champion --trials 16 --workers {workers}"));
    assert_eq!(champions(1), champions(2));
}

#[test]
fn the_same_engine_comes_to_the_same_shares() {
    let place = place();
    for line in place.ask("transfer best --trials 32 --to lockstep") {
        assert_eq!((&line["engine"], &line["to"]), (&"lockstep".into(), &"lockstep".into()));
        for key in ["reach", "open", "grasp", "move", "all"] {
            assert_eq!(line[key], line[format!("to_{key}")]);
        }
    }
}

#[test]
fn what_names_no_individual_is_refused() {
    let place = Place::new();
    place.run("run small.toml --set generations=1").done();
    for command in ["show", "evaluate", "transfer --to lockstep"] {
        for (reference, words) in [
            ("small/0/0", "`small/0/0` names no individual; expected `best`, `champion` or EXPERIMENT/"),
            ("large/0/0/0", "large/0/0/0: there is no experiment `large`; there is: small"),
            ("small/2/0/0", "small/2/0/0: there is no replication 2; they go from 0 to 1"),
            ("small/0/1/0", "small/0/1/0: there is no generation 1; there is only generation 0"),
            ("small/0/0/20", "small/0/0/20: there is no individual 20; they go from 0 to 19"),
            ("best --generation 3", "there is no generation 3; there is only generation 0"),
            ("champion --replication 2", "there is no replication 2"),
        ] {
            let message = place.run(&format!("{command} {reference}")).refused(2);
            assert!(message.starts_with(words), "{message}");
        }
        place.run(&format!("{command} --db none.db")).refused(4);
    }
    for words in ["evaluate --trials 17", "evaluate --trials 0", "transfer --to none"] {
        assert_eq!(place.run(words).code, Some(2), "{words}");
    }
}
