//! Looking at stored individuals: their trials again, and fresh ones.

use selftalk_tests::Place;
use serde_json::Value;
use sqlx::Connection;

const GENERATIONS: u64 = 5;

/// Changes what is stored, as no master would.
fn tamper(place: &Place, statement: &str) {
    let path = place.path("history.db");
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        let options = sqlx::sqlite::SqliteConnectOptions::new().filename(path);
        let mut connection = sqlx::SqliteConnection::connect_with(&options).await.unwrap();
        let changed = sqlx::query(sqlx::AssertSqlSafe(statement))
            .execute(&mut connection)
            .await
            .unwrap()
            .rows_affected();
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
    let place = Place::with_history(GENERATIONS);
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
    let place = Place::with_history(GENERATIONS);
    let best = &place.ask("history individuals --best --replication 0")[0];
    tamper(
        &place,
        "UPDATE trial SET score = score + 1e-9 WHERE replication_id = 1 AND generation = 4 AND trial = 6",
    );
    let message = place.run("show --replication 0").refused(7);
    assert!(message.starts_with(&format!("{}: trial 6: score 0.", name(best))), "{message}");
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
    let place = Place::with_history(GENERATIONS);
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
fn failures_are_told_trial_by_trial() {
    let place = Place::with_history(GENERATIONS);
    let lines = place.ask("evaluate best --trials 64 --why --replication 1");
    let shares = &place.ask("evaluate best --trials 64 --replication 1")[0];
    assert_eq!(lines.len(), 16);
    let successes = |line: &Value| line["successes"].as_u64().unwrap();
    assert_eq!(lines.iter().map(successes).sum::<u64>() as f64, 64.0 * shares["all"].as_f64().unwrap());
    for (number, line) in lines.iter().enumerate() {
        assert_eq!((&line["trial"], &line["trials"]), (&number.into(), &4.into()));
        assert_eq!(line["reasons"] == "", successes(line) == 4, "{line}");
    }
    let words = lines[0]["reasons"].as_str().unwrap();
    assert!(words.contains("never palm to top, palm to top 0."), "{words}");
}

#[test]
fn the_same_engine_comes_to_the_same_shares() {
    let place = Place::with_history(GENERATIONS);
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

#[test]
fn an_honest_history_is_verified() {
    let place = Place::with_history(GENERATIONS);
    let before = place.read("history.db");
    let replications = place.ask("verify");
    let distinct = |replication: u64| -> u64 {
        let generations = place.ask(&format!("history generations --replication {replication}"));
        generations.iter().map(|line| line["distinct"].as_u64().unwrap()).sum()
    };
    for (number, line) in (0..).zip(&replications) {
        assert_eq!((&line["replication"], &line["mismatches"]), (&number.into(), &0.into()));
        assert_eq!(line["genotypes"], distinct(number));
        assert_eq!(line["trials"], 16 * distinct(number));
    }
    let asked = |words: &str| -> (usize, u64) {
        let lines = place.ask(&format!("verify {words}"));
        assert!(lines.iter().all(|line| line["mismatches"] == 0), "{lines:?}");
        (lines.len(), lines.iter().map(|line| line["genotypes"].as_u64().unwrap()).sum())
    };
    assert_eq!(asked("--best"), (2, 2 * GENERATIONS));
    assert_eq!(asked("--sample 9"), (2, 9));
    assert_eq!(asked("--best --replication 1 --generation 1-2"), (1, 2));
    let message = place.run("verify --generation 7-9").refused(2);
    assert_eq!(message, "there is no generation 7; they go from 0 to 4");
    assert!(place.read("history.db") == before, "nothing is written");
}

#[test]
fn a_history_that_was_tampered_with_is_found_out_by_name() {
    let place = Place::with_history(GENERATIONS);
    let sound = place.read("history.db");
    // The first individual: verify stops naming mismatches after some.
    let number = 0;
    let rank = "UPDATE individual SET rank = 19 - rank WHERE generation = 3";
    let outcome = |what: &str| format!("UPDATE trial SET {what} WHERE replication_id = 1 AND generation = 2");
    for (statement, words) in [
        (outcome("score = score + 1e-9"), format!("small/0/2/{number}: trial 5: score 0.")),
        (
            outcome("steps = steps + 1"),
            format!("small/0/2/{number}: trial 0: 9 steps are stored, 8 come out"),
        ),
        (outcome("success = 1 - success"), format!("small/0/2/{number}: trial 15: ")),
        ("UPDATE evaluation SET fitness = fitness + 1e-9".to_owned(), "small/0/4/0: fitness 0.".to_owned()),
        (rank.to_owned(), "small/0/4/0: a copy of ".to_owned()),
        (rank.to_owned(), "has rank 0, which belongs to individual ".to_owned()),
        (
            "UPDATE generation SET most_successes = 17".to_owned(),
            "small/1/0: most successes 17 is".to_owned(),
        ),
    ] {
        place.write("history.db", &sound);
        tamper(&place, &statement);
        let outcome = place.run("verify");
        let named =
            outcome.stderr.lines().any(|line| line.starts_with("mismatch: small/") && line.contains(&words));
        assert!(named, "{statement}: {words}: {}", outcome.stderr);
        assert!(outcome.failed(7).contains(" mismatches; the first: small/"));
    }
    place.write("history.db", &sound);
    tamper(
        &place,
        "UPDATE trial SET score = 0.5 WHERE replication_id = 2 AND generation = 4 AND individual = 0 AND trial = 3",
    );
    let message = place.run("verify --replication 1 --generation 4").failed(7);
    assert!(message.starts_with("2 mismatches; the first: small/1/4/0: "), "{message}");
    place.run("verify --replication 0").done();
    place.run("verify --replication 1 --generation 0-3").done();
}

#[test]
fn results_are_written_verified_and_found_out() {
    let place = Place::with_history(GENERATIONS);
    place.run("results --out kept/small --trials 32").done();
    let read = |name: &str| String::from_utf8(place.read(&format!("kept/small/{name}"))).unwrap();
    let summary = read("summary.csv");
    let mut lines = summary.lines();
    assert_eq!(
        lines.next(),
        Some(
            "replication,generations,first_optimal_generation,best_successes_of_16,fresh_reach,fresh_open,\
             fresh_grasp,fresh_move"
        )
    );
    let champions = place.ask("evaluate champion --trials 32");
    assert_eq!(champions.len(), lines.clone().count());
    for (champion, line) in champions.iter().zip(lines) {
        let fields: Vec<&str> = line.split(',').collect();
        assert_eq!((fields[0], fields[1]), (champion["replication"].to_string().as_str(), "5"));
        for (field, key) in fields[4..].iter().zip(["reach", "open", "grasp", "move"]) {
            assert_eq!(field.parse::<f64>().unwrap(), champion[key].as_f64().unwrap(), "{line}");
        }
    }
    assert_eq!(read("generations.csv").lines().count() as u64, 1 + 2 * GENERATIONS);
    assert_eq!(read("trials.csv").lines().count(), 1 + 2 * 16);
    let document = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/results/README.md");
    let document = std::fs::read_to_string(document).unwrap();
    for file in ["generations.csv", "summary.csv", "best.csv", "trials.csv", "digest.csv", "workers.csv"] {
        let (_, section) = document.split_once(&format!("### {file}")).unwrap();
        let section = section.split("###").next().unwrap();
        for column in read(file).lines().next().unwrap().split(',') {
            assert!(section.contains(&format!("`{column}`")), "{file}: {column} is not documented");
        }
    }
    assert_eq!(read("workers.csv").lines().count(), 1 + place.ask("history workers").len());
    let figure = read("figure.svg");
    assert!(figure.contains("replication 1") && document.contains("### figure.svg"), "{figure}");
    for digest in place.digests() {
        assert!(read("digest.csv").contains(&digest));
    }
    let rerun = place.run("run kept/small/experiment.toml --db again.db").done();
    assert!(rerun.stdout.contains("finished"), "{rerun:?}");

    let verified = &place.ask("verify --results kept/small")[0];
    assert_eq!((&verified["individuals"], &verified["mismatches"]), (&2.into(), &0.into()));
    assert_eq!(verified["trials"], 2 * (16 + 160 + 32));
    let message = place.run("results --out kept/small").refused(2);
    assert_eq!(message, "kept/small: is not empty; name a new folder with --out");

    let sound = read("trials.csv");
    let bits = sound.lines().nth(1 + 16 + 4).unwrap().split(',').nth(4).unwrap();
    let other = format!("{:016x}", u64::from_str_radix(bits, 16).unwrap() ^ 1);
    place.write("kept/small/trials.csv", sound.replace(bits, &other));
    let champion = name(&champions[1]);
    let outcome = place.run("verify --results kept/small");
    assert!(outcome.stderr.contains(&format!("mismatch: {champion}: trial 4: score 0.")), "{outcome:?}");
    outcome.failed(7);
    place.write("kept/small/trials.csv", sound);
    place.write("kept/small/summary.csv", summary.replace("\n1,5,", "\n1,6,"));
    let message = place.run("verify --results kept/small").failed(7);
    assert!(message.contains("small/1: generations.csv does not have 6 generations, as"), "{message}");
    place.run("verify --results kept/none").refused(2);
    place.run("results none --out kept/none").refused(2);
}
