//! The dashboard of a run, and of any database: what it answers, where it is, and whom it answers.

use std::net::TcpListener;

use selftalk_tests::{Page, Place, wait_until};
use serde_json::Value;
use sqlx::Connection;

/// A run that goes on for as long as a test may need it.
const ENDLESS: &str = "run small.toml --workers 1 --set generations=100000 --dashboard 127.0.0.1:0";

#[test]
fn a_run_is_shown_while_it_goes_on() {
    let place = Place::new();
    let mut run = place.start(ENDLESS);
    let address = run.dashboard();
    assert_eq!(Page::get(&address, "/healthz").status, 200);
    wait_until("it is ready", || (Page::get(&address, "/readyz").status == 200).then_some(()));
    let generations = |overview: &Value| {
        let replications = overview["experiments"][0]["replications"].as_array().unwrap().clone();
        replications.iter().map(|replication| replication["generations"].as_u64().unwrap()).sum::<u64>()
    };
    let early = wait_until("a generation", || {
        Some(Page::json(&address, "/api/overview")).filter(|overview| generations(overview) > 2)
    });
    let later = wait_until("more generations, and what the worker is at", || {
        let overview = Page::json(&address, "/api/overview");
        let busy = overview["live"]["workers"][0]["trials_per_second"].as_f64() > Some(0.0);
        (busy && generations(&overview) > generations(&early)).then_some(overview)
    });
    let live = &later["live"];
    assert_eq!((&live["slots"], live["workers"].as_array().unwrap().len()), (&1.into(), 1));
    assert!(live["seconds_left"].as_f64() > Some(0.0), "{live}");
    assert_eq!(later["experiments"][0]["replications"][1]["state"], "running");

    let metrics = Page::get(&address, "/metrics");
    assert!(metrics.head.contains("content-type: text/plain; version=0.0.4"), "{}", metrics.head);
    let measured = |name: &str| {
        let line = metrics.body.lines().find_map(|line| line.strip_prefix(name)).unwrap_or_default();
        line.trim().parse::<f64>().unwrap_or_else(|_| panic!("{name}: {}", metrics.body))
    };
    assert!(measured("selftalk_generations_total{experiment=\"small\",replication=\"0\"}") > 0.0);
    assert_eq!((measured("selftalk_workers "), measured("selftalk_slots ")), (1.0, 1.0));
    assert!(measured("selftalk_trials_total ") > 0.0);

    // The last generation is looked at while the next is under way, and played.
    let last = later["experiments"][0]["replications"][0]["generations"].as_u64().unwrap() - 1;
    let best = &Page::json(&address, &format!("/api/experiments/small/0/{last}"))["individuals"][0];
    let name = format!("small/0/{last}/{}", best["individual"]);
    let individual = Page::json(&address, &format!("/api/experiments/{name}"));
    assert_eq!(individual["lineage"].as_array().unwrap().len() as u64, last + 1);
    let replay = Page::get(&address, &format!("/experiments/{name}/replay"));
    assert!(replay.status == 200 && replay.body.contains(&name), "{}", replay.status);
    assert!(replay.head.contains("script-src 'sha256-"), "{}", replay.head);

    for method in ["POST", "PUT", "DELETE"] {
        assert_eq!(Page::request(&address, &format!("{method} /"), &address).unwrap().status, 405);
    }
    assert_eq!(Page::request(&address, "GET /", "rebound.example.org").unwrap().status, 403);
    assert!(run.is_running(), "{}", run.reported());
}

#[test]
fn being_looked_at_changes_no_bit_and_leaves_nothing_behind() {
    let place = Place::new();
    let mut run = place.start("run small.toml --workers 1 --dashboard 127.0.0.1:0");
    let address = run.dashboard();
    while run.is_running() {
        for path in
            ["/api/overview", "/api/experiments/small/curves", "/api/experiments/small/0/1/2", "/metrics"]
        {
            // It may be gone by now.
            let _ = Page::request(&address, &format!("GET {path}"), &address);
        }
    }
    run.end().done();
    let alone = Place::new();
    alone.run("run small.toml --workers 1 --dashboard off").done();
    assert_eq!(place.digests(), alone.digests());
    assert!(std::fs::metadata(place.path("history.db-wal")).map_or(0, |log| log.len()) == 0);
}

#[test]
fn a_finished_file_is_shown_without_a_master() {
    let place = Place::with_history(2);
    let before = place.read("history.db");
    let mut dashboard = place.start("dashboard --listen 127.0.0.1:0");
    let address = dashboard.dashboard();
    let overview = Page::json(&address, "/api/overview");
    assert_eq!((&overview["live"], &overview["file"]), (&Value::Null, &"history.db".into()));
    assert_eq!(overview["experiments"][0]["state"], "finished");
    assert_eq!(Page::json(&address, "/api/workers")[0]["slots"], 1);
    let curves = Page::json(&address, "/api/experiments/small/curves");
    assert_eq!(curves["replications"][1]["generation"], serde_json::json!([0, 1]));
    assert!(Page::get(&address, "/api/experiments/small/settings").body.contains("name = \"small\""));
    assert_eq!(Page::get(&address, "/experiments/small/0/1/3/replay").status, 200);
    assert!(!Page::get(&address, "/metrics").body.contains("selftalk_workers"));
    assert!(dashboard.is_running());
    assert_eq!(place.read("history.db"), before);
}

#[cfg(unix)]
#[test]
fn ctrl_c_is_how_a_dashboard_ends() {
    let place = Place::with_history(1);
    let mut dashboard = place.start("dashboard --listen 127.0.0.1:0");
    let _ = dashboard.dashboard();
    dashboard.signal(rustix::process::Signal::INT);
    dashboard.end().done();
}

#[tokio::test]
async fn individuals_of_another_simulator_are_shown_and_not_replayed() {
    let place = Place::with_history(1);
    let address = format!("sqlite://{}", place.path("history.db").display());
    let mut file = sqlx::SqliteConnection::connect(&address).await.unwrap();
    sqlx::query("UPDATE experiment SET fingerprint = 'of another release'").execute(&mut file).await.unwrap();
    file.close().await.unwrap();
    let mut dashboard = place.start("dashboard --listen 127.0.0.1:0");
    let address = dashboard.dashboard();
    let individual = Page::json(&address, "/api/experiments/small/0/0/3");
    let why = individual["foreign"].as_str().unwrap();
    assert!(why.contains("of another release"), "{why}");
    let replay = Page::get(&address, "/experiments/small/0/0/3/replay");
    assert_eq!(replay.status, 409);
    assert!(
        replay.body.starts_with("small/0/0/3 cannot be replayed: run with a simulator"),
        "{}",
        replay.body
    );
}

#[test]
fn a_dashboard_is_where_it_is_asked_to_be() {
    let place = Place::new();
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let taken = taken.local_addr().unwrap();
    for command in ["run small.toml --dashboard", "serve small.toml --listen 127.0.0.1:0 --dashboard"] {
        let held = TcpListener::bind(taken);
        let address = held.as_ref().map_or(taken, |held| held.local_addr().unwrap());
        let message = place.run(&format!("{command} {address}")).refused(5);
        assert!(message.starts_with(&format!("{address}: cannot listen: ")), "{message}");
        let message = place.run(&format!("{command} 0.0.0.0:0")).refused(2);
        let expected =
            "--dashboard 0.0.0.0:0: other machines could read along, as nothing is encrypted; add --insecure";
        assert!(message.starts_with(expected), "{message}");
    }
    let message = place.run("run small.toml --dashboard localhost:1");
    assert!(
        message.code == Some(2) && message.stderr.contains("such as 127.0.0.1:7780, or `off`"),
        "{message:?}"
    );
    let message = place.run("dashboard").refused(4);
    assert!(message.contains("history.db: no such file"), "{message}");
    assert!(!place.path("history.db").exists());

    let quiet = place.run("run small.toml --set generations=1 --dashboard off").done();
    assert!(!quiet.stderr.contains("dashboard"), "{}", quiet.stderr);
    let message = place.run("dashboard --listen 0.0.0.0:0").refused(2);
    assert!(message.starts_with("--listen 0.0.0.0:0: other machines could read along"), "{message}");
    let mut open = place.start("dashboard --listen 0.0.0.0:0 --insecure");
    let address = open.dashboard().replace("0.0.0.0", "127.0.0.1");
    assert_eq!(Page::request(&address, "GET /readyz", "lab.example.org").unwrap().status, 200);
}

#[test]
fn where_the_usual_port_is_taken_another_is_said() {
    let place = Place::with_history(1);
    let Ok(_held) = TcpListener::bind("127.0.0.1:7780") else {
        eprintln!("port 7780 is another program's at present; nothing is tested");
        return;
    };
    let mut dashboard = place.start("dashboard");
    let address = dashboard.dashboard();
    assert_eq!(Page::get(&address, "/readyz").status, 200);
    assert!(dashboard.reported().contains("/ (port 7780 is taken)"), "{}", dashboard.reported());
}
