//! What the dashboard answers, over a socket as a browser asks.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::sync::Arc;

use serde_json::Value;
use tempfile::TempDir;
use tokio::net::TcpListener;
use tokio::sync::watch;
use tokio_util::sync::CancellationToken;

use super::*;
use crate::driver::{Board, Standing};
use crate::service::{Attendance, Floor};
use crate::store::tests::{experiment, run};
use crate::store::{SqliteStore, Store, WorkerId};

/// A dashboard in this process.
struct Site {
    address: SocketAddr,
    stage: Stage,
    shutdown: CancellationToken,
    folder: TempDir,
}

impl Drop for Site {
    fn drop(&mut self) {
        self.shutdown.cancel();
    }
}

impl Site {
    /// A dashboard that shows nothing yet.
    async fn dark() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let (stage, shutdown) = (Stage::new(), CancellationToken::new());
        tokio::spawn(serve(listener, stage.clone(), shutdown.clone()));
        Self { address, stage, shutdown, folder: tempfile::tempdir().unwrap() }
    }

    /// One that shows so many generations of made-up evolution.
    async fn of(generations: u32, live: Option<Live>) -> Self {
        let site = Self::dark().await;
        let path = site.folder.path().join("history.db");
        let store = SqliteStore::open_writer(&path).await.unwrap();
        run(&store, &experiment("e"), generations).await;
        store.close().await.unwrap();
        site.show(&path, live).await;
        site
    }

    async fn show(&self, path: &Path, live: Option<Live>) {
        let store = SqliteStore::open_reader(path).await.unwrap();
        self.stage.show(Sources::new(store, "history.db".to_owned(), "sim-1".to_owned(), live));
    }

    /// The status and what is said, and the headers.
    async fn ask(&self, request: &str) -> (u16, String, String) {
        let (address, request) = (self.address, request.to_owned());
        let asked = tokio::task::spawn_blocking(move || {
            let mut stream = TcpStream::connect(address).unwrap();
            stream.write_all(request.as_bytes()).unwrap();
            let mut answer = String::new();
            stream.read_to_string(&mut answer).unwrap();
            answer
        });
        let answer = asked.await.unwrap();
        let (head, body) = answer.split_once("\r\n\r\n").unwrap();
        let status = head.split(' ').nth(1).unwrap().parse().unwrap();
        (status, body.to_owned(), head.to_lowercase())
    }

    async fn get(&self, path: &str) -> (u16, String) {
        let (status, body, _) =
            self.ask(&format!("GET {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")).await;
        (status, body)
    }

    async fn json(&self, path: &str) -> Value {
        let (status, body) = self.get(path).await;
        assert_eq!(status, 200, "{path}: {body}");
        serde_json::from_str(&body).unwrap()
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_dashboard_is_ready_while_it_has_something_to_show() {
    let site = Site::dark().await;
    assert_eq!(site.get("/healthz").await.0, 200);
    assert_eq!(site.get("/readyz").await.0, 503);
    let (status, body) = site.get("/api/overview").await;
    assert_eq!(status, 503);
    assert!(body.contains("the database is not open"), "{body}");
    assert_eq!(site.get("/").await.0, 200, "the page asks again");

    let path = site.folder.path().join("history.db");
    let writer = SqliteStore::open_writer(&path).await.unwrap();
    site.show(&path, None).await;
    assert_eq!(site.get("/readyz").await.0, 200);
    assert_eq!(site.json("/api/overview").await["experiments"], serde_json::json!([]));
    site.stage.clear().await.unwrap();
    assert_eq!(site.get("/readyz").await.0, 503);
    // Nobody else has the file any more, so closing it leaves everything in it.
    writer.close().await.unwrap();
    let log = std::fs::metadata(site.folder.path().join("history.db-wal"));
    assert!(log.map_or(0, |log| log.len()) == 0);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_overview_has_every_replication_and_the_master() {
    let standing = |replication, finished| Standing {
        experiment: "e".to_owned(),
        replication,
        generations: 3,
        of: 130,
        trials: 16,
        finished,
        last: None,
    };
    let board = watch::Sender::new(Board { standings: vec![standing(0, false), standing(1, true)] });
    let worker = Attendance {
        worker: WorkerId(1),
        name: Arc::from("vm-1-0001"),
        host: Arc::from("vm"),
        slots: 4,
        units: 7,
        trials: 160,
        trials_per_second: 12.5,
        silence: Duration::from_millis(1500),
    };
    let floor =
        Floor { workers: vec![worker], waiting: 30, paused: false, leased: 7, units: 10, trials: 160 };
    let floor = watch::Sender::new(floor);
    let site = Site::of(3, Some(Live { board: board.subscribe(), floor: floor.subscribe() })).await;

    let overview = site.json("/api/overview").await;
    let condition = &overview["experiments"][0];
    assert_eq!((&condition["name"], &condition["state"]), (&"e".into(), &"running".into()));
    assert_eq!((&condition["trials"], &condition["foreign"]), (&16.into(), &Value::Null));
    let states: Vec<&Value> =
        condition["replications"].as_array().unwrap().iter().map(|of| &of["state"]).collect();
    assert_eq!(states, ["running", "unfinished"]);
    let live = &overview["live"];
    assert_eq!((&live["workers"][0]["name"], &live["slots"]), (&"vm-1-0001".into(), &4.into()));
    assert_eq!(live["workers"][0]["silent_seconds"], 1.5);
    // 127 generations of 1.234 s.
    assert!((live["seconds_left"].as_f64().unwrap() - 127.0 * 1.234).abs() < 1e-6, "{live}");

    let (_, metrics) = site.get("/metrics").await;
    for line in [
        "selftalk_generations_total{experiment=\"e\",replication=\"1\"} 3",
        "selftalk_generations_planned{experiment=\"e\",replication=\"0\"} 130",
        "selftalk_workers 1",
        "selftalk_slots 4",
        "selftalk_units_waiting 30",
        "selftalk_units_leased 7",
        "selftalk_trials_total 160",
    ] {
        assert!(metrics.lines().any(|other| other == line), "{line}: {metrics}");
    }
    for line in metrics.lines().filter(|line| !line.starts_with('#')) {
        let (name, value) = line.rsplit_once(' ').unwrap();
        assert!(name.starts_with("selftalk_") && value.parse::<f64>().is_ok(), "{line}");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn curves_have_only_what_is_new_and_no_more_than_can_be_drawn() {
    let site = Site::of(6, None).await;
    let all = site.json("/api/experiments/e/curves").await;
    assert_eq!((&all["stride"], all["replications"].as_array().unwrap().len()), (&1.into(), 2));
    let curve = &all["replications"][1];
    assert_eq!(curve["generation"], serde_json::json!([0, 1, 2, 3, 4, 5]));
    assert_eq!(curve["best"].as_array().unwrap().len(), 6);
    let new = site.json("/api/experiments/e/curves?since=4").await;
    assert_eq!(new["replications"][1]["generation"], serde_json::json!([4, 5]));
    assert_eq!(new["replications"][1]["best"][1], curve["best"][5]);

    let store = SqliteStore::open_reader(&site.folder.path().join("history.db")).await.unwrap();
    let replication = store.experiments().await.unwrap()[0].replications[0].id;
    let points = store.list_curve(replication, 0, 4).await.unwrap();
    let generations: Vec<u32> = points.iter().map(|point| point.generation).collect();
    assert_eq!(generations, [0, 4, 5], "every fourth and the last");
    assert_eq!(store.recent_wall_ms(replication, 3).await.unwrap(), Some(1234.0));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_individual_has_its_trials_its_ancestors_and_its_children() {
    let site = Site::of(4, None).await;
    let generation = site.json("/api/experiments/e/1/2").await;
    let individuals = generation["individuals"].as_array().unwrap();
    assert_eq!((individuals.len(), &generation["generations"]), (100, &4.into()));
    assert!(individuals.iter().enumerate().all(|(rank, individual)| individual["rank"] == rank));

    let number = individuals[0]["individual"].as_u64().unwrap();
    let best = site.json(&format!("/api/experiments/e/1/2/{number}")).await;
    assert_eq!((&best["rank"], &best["fitness"]), (&0.into(), &individuals[0]["fitness"]));
    let trials = best["trials"].as_array().unwrap();
    assert_eq!((trials.len(), &trials[5]["behaviour"]), (16, &"open".into()));
    let successes = trials.iter().filter(|trial| trial["success"] == true).count();
    assert_eq!(best["successes"], successes);
    let lineage: Vec<&Value> =
        best["lineage"].as_array().unwrap().iter().map(|ancestor| &ancestor["generation"]).collect();
    assert_eq!(lineage, [2, 1, 0]);
    assert_eq!(best["lineage"][2]["origin"], "founder");
    assert_eq!(best["children"].as_array().unwrap().len(), 5, "the best have five children");

    for (path, words) in [
        ("/api/experiments/none/curves", "there is no experiment `none`"),
        ("/api/experiments/e/7/0", "there is no replication 7"),
        ("/api/experiments/e/1/9", "there is no generation 9"),
        ("/api/experiments/e/1/9/0", "there is no generation 9"),
        ("/api/experiments/e/1/2/100", "there is no individual 100"),
        ("/experiments/e/1/9/0/replay", "there is no generation 9"),
        ("/elsewhere", "there is nothing at this address"),
    ] {
        let (status, body) = site.get(path).await;
        assert!(status == 404 && body.contains(words), "{path}: {status} {body}");
    }
    assert_eq!(site.get("/api/experiments/e/one/2").await.0, 400);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn only_this_machine_is_answered_and_only_reading() {
    let site = Site::of(1, None).await;
    for method in ["POST", "PUT", "DELETE", "PATCH", "OPTIONS"] {
        let request = format!("{method} / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
        let (status, _, head) = site.ask(&request).await;
        assert!(status == 405 && head.contains("allow: get, head"), "{method}: {head}");
    }
    for host in ["Host: example.org\r\n", "Host: 127.0.0.1.example.org:80\r\n", ""] {
        let request = format!("GET /api/overview HTTP/1.1\r\n{host}Connection: close\r\n\r\n");
        let (status, body, _) = site.ask(&request).await;
        assert!(matches!(status, 400 | 403) && !body.contains("experiments"), "{host}: {status} {body}");
    }
    let (status, _, head) =
        site.ask("HEAD / HTTP/1.1\r\nHost: [::1]:7780\r\nConnection: close\r\n\r\n").await;
    assert_eq!(status, 200);
    assert!(head.contains("content-security-policy: default-src 'none'; script-src 'self'"), "{head}");
}
