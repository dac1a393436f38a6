//! `history` and `digest`, from the command line to what is printed.

use std::path::{Path, PathBuf};

use clap::Parser;
use serde_json::Value;

use super::output::Lines;
use super::{Cli, Command, Format, digest, execute, history, select};
use crate::evolution::founders;
use crate::exit::{Exit, Failure};
use crate::store::tests::{GENES, commit, evaluate, experiment, run};
use crate::store::{SqliteStore, Store, WorkerInfo};

/// Two experiments: `a` with 8 generations of 2 replications, `b` just begun by a worker, in its second replication.
async fn filled() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.db");
    let store = SqliteStore::open_writer(&path).await.unwrap();
    let mut a = experiment("a");
    a.generations = 8;
    run(&store, &a, 8).await;
    let b = store.create_experiment(&experiment("b"), "sim-1").await.unwrap();
    let info = WorkerInfo {
        name: "node-7".to_owned(),
        host: "h".to_owned(),
        process: 42,
        version: "0.1.0".to_owned(),
        slots: 2,
    };
    let worker = store.worker_joined(&info).await.unwrap();
    let record = evaluate(founders(&experiment("b"), GENES, 1), Some(worker));
    commit(&store, b.replications[1].id, &record, false).await.unwrap();
    store.close().await.unwrap();
    (folder, path)
}

async fn answer(path: &Path, words: &str) -> Result<Lines, Failure> {
    let cli = Cli::try_parse_from(["selftalk"].into_iter().chain(words.split(' '))).unwrap();
    let store = SqliteStore::open_reader(path).await.unwrap();
    match cli.command {
        Command::History(args) => history::lines(&store, &args.what, Format::Json).await,
        Command::Digest(args) => Ok(Lines::of(digest::table(&store, &args).await?, Format::Json)),
        other => panic!("{other:?}"),
    }
}

/// The answer as JSON objects.
async fn objects(path: &Path, words: &str) -> Vec<Value> {
    serde_json::from_slice(&answer(path, words).await.unwrap().text().unwrap()).unwrap()
}

#[tokio::test]
async fn experiments_and_replications_show_how_far_they_are() {
    let (_folder, path) = filled().await;
    let experiments = objects(&path, "history experiments").await;
    assert_eq!(experiments.len(), 2);
    assert_eq!((&experiments[0]["state"], &experiments[0]["generations"]), (&"finished".into(), &16.into()));
    assert_eq!((&experiments[1]["state"], &experiments[1]["planned"]), (&"running".into(), &260.into()));
    let replications = objects(&path, "history replications --replication 1").await;
    assert_eq!(replications.len(), 2);
    assert_eq!(replications[0]["generations"], 8);
    assert_eq!(replications[1]["generations"], 1);
    let unbegun = objects(&path, "history replications --experiment b --replication 0").await;
    assert_eq!(unbegun[0]["best_fitness"], Value::Null);
}

#[tokio::test]
async fn generations_are_listed_and_filtered() {
    let (_folder, path) = filled().await;
    assert_eq!(objects(&path, "history generations").await.len(), 17);
    let all = objects(&path, "history generations --experiment a --replication 1").await;
    assert!(all.iter().enumerate().all(|(number, entry)| entry["generation"] == number));
    let third = objects(&path, "history generations --experiment a --replication 1 --generation 3").await;
    assert_eq!(third, all[3..4]);
    let best = objects(&path, "history generations --experiment a --replication 1 --best").await;
    let highest = all.iter().map(|entry| entry["best_fitness"].as_f64().unwrap()).fold(0.0, f64::max);
    assert_eq!(best.len(), 1);
    assert_eq!(best[0]["best_fitness"], highest);
}

#[tokio::test]
async fn individuals_are_those_of_the_last_generation_unless_said_otherwise() {
    let (_folder, path) = filled().await;
    let last = objects(&path, "history individuals --experiment a --replication 0").await;
    assert_eq!(last.len(), 100);
    assert!(last.iter().enumerate().all(|(rank, entry)| entry["rank"] == rank && entry["generation"] == 7));
    let best = objects(&path, "history individuals --best").await;
    assert_eq!(best.len(), 3);
    assert_eq!(best[0], last[0]);
    assert_eq!(best[2]["worker"], "node-7");
    let founders = objects(&path, "history individuals --generation 0 --replication 0 --genes").await;
    assert!(
        founders.iter().all(|entry| entry["origin"] == "founder" && entry["flipped"] == Value::Array(vec![]))
    );
    let genes: Vec<_> = founders.iter().filter_map(|entry| entry["genes"].as_str()).collect();
    assert_eq!(genes.len(), 100);
    assert!(genes.iter().all(|genes| genes.len() == 4 * GENES));
}

#[tokio::test]
async fn a_lineage_leads_from_parent_to_parent_to_a_founder() {
    let (_folder, path) = filled().await;
    let line = objects(&path, "history lineage --experiment a --replication 0").await;
    assert_eq!(line.len(), 8);
    assert_eq!(line[0]["rank"], 0);
    assert_eq!(line[7]["origin"], "founder");
    for (child, parent) in line.iter().zip(&line[1..]) {
        assert_eq!(child["parent"], parent["individual"]);
        assert_eq!(child["generation"].as_u64().unwrap(), parent["generation"].as_u64().unwrap() + 1);
    }
    // The flips along the line lead from the founder's genes to the individual's.
    let genes = async |generation: u64, individual: &Value| -> String {
        let words =
            format!("history individuals --experiment a --replication 0 --generation {generation} --genes");
        let all = objects(&path, &words).await;
        all.iter().find(|entry| entry["individual"] == *individual).unwrap()["genes"]
            .as_str()
            .unwrap()
            .to_owned()
    };
    let bits = |hex: &str| -> Vec<bool> {
        let gene = |at: usize| u16::from_str_radix(&hex[4 * at..4 * at + 4], 16).unwrap();
        (0..GENES * 16).map(|bit| gene(bit / 16) >> (bit % 16) & 1 == 1).collect()
    };
    let mut expected = bits(&genes(0, &line[7]["individual"]).await);
    for bit in line.iter().flat_map(|entry| entry["flipped"].as_array().unwrap()) {
        expected[bit.as_u64().unwrap() as usize] ^= true;
    }
    assert_eq!(bits(&genes(7, &line[0]["individual"]).await), expected);
    let other =
        objects(&path, "history lineage --experiment a --replication 0 --generation 2 --individual 99").await;
    assert_eq!((other.len(), &other[0]["individual"]), (3, &99.into()));
}

#[tokio::test]
async fn workers_are_listed() {
    let (_folder, path) = filled().await;
    let workers = objects(&path, "history workers").await;
    assert_eq!(workers.len(), 1);
    assert_eq!((&workers[0]["name"], &workers[0]["left_at"]), (&"node-7".into(), &Value::Null));
}

#[tokio::test]
async fn what_is_not_there_is_a_usage_failure_that_says_what_is() {
    let (_folder, path) = filled().await;
    for (words, message) in [
        ("history generations --experiment c", "there is no experiment `c`; there is: a, b"),
        ("digest c", "there is no experiment `c`; there is: a, b"),
        ("history replications --replication 2", "there is no replication 2; they go from 0 to 1"),
        ("history individuals --generation 8", "there is no generation 8; they go from 0 to 7"),
        (
            "history generations --experiment b --replication 0 --generation 1",
            "there is no generation 1; there is none yet",
        ),
        (
            "history lineage --experiment a --individual 100",
            "there is no individual 100; they go from 0 to 99",
        ),
    ] {
        assert_eq!(answer(&path, words).await.err(), Some(Failure::new(Exit::Usage, message)), "{words}");
    }
    assert!(objects(&path, "history individuals --experiment b --replication 0").await.is_empty());
}

#[tokio::test]
async fn digests_depend_on_the_evolution_and_not_on_names() {
    let (folder, path) = filled().await;
    let lines = objects(&path, "digest a").await;
    assert_eq!(lines.len(), 2);
    assert_eq!(lines[0]["generations"], 8);
    assert_ne!(lines[0]["sha256"], lines[1]["sha256"]);
    let other = folder.path().join("other.db");
    let store = SqliteStore::open_writer(&other).await.unwrap();
    let mut renamed = experiment("renamed");
    renamed.generations = 8;
    run(&store, &renamed, 3).await;
    let partial = objects(&other, "digest").await;
    assert_ne!(partial[0]["sha256"], lines[0]["sha256"]);
    run(&store, &renamed, 5).await;
    let whole = objects(&other, "digest").await;
    assert_eq!(whole[0]["sha256"], lines[0]["sha256"]);
    assert_eq!(whole[1]["sha256"], lines[1]["sha256"]);
}

#[tokio::test]
async fn a_missing_database_is_a_database_failure_and_stays_missing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("none.db");
    for words in ["history experiments", "history lineage", "digest"] {
        let words = ["selftalk", "--db", path.to_str().unwrap()].into_iter().chain(words.split(' '));
        let failure = execute(Cli::try_parse_from(words).unwrap()).await.unwrap_err();
        assert_eq!(failure.exit, Exit::Database);
        assert!(failure.message.contains("no such file"), "{failure}");
    }
    assert!(!path.exists());
}

#[tokio::test]
async fn a_filter_by_name_is_exact() {
    let (_folder, path) = filled().await;
    let store = SqliteStore::open_reader(&path).await.unwrap();
    assert!(select::experiments(&store, Some("A")).await.is_err());
    assert_eq!(select::experiments(&store, Some("b")).await.unwrap().len(), 1);
}
