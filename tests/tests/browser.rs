//! Pages in a real browser: Chromium without a window. Without Chromium (`apt install chromium`) nothing is tested here.

// Helpers of tests are test code as well, though the compiler cannot know it.
#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used)]

use std::process::Command;

use selftalk_tests::Place;

/// What the document is after some seconds of the page's own time, and what the browser had to say; none without one.
fn visited(place: &Place, page: &str) -> Option<(String, String)> {
    let profile = place.path("profile");
    let mut browser = Command::new("chromium");
    browser.args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"]);
    browser.args(["--disable-background-networking", "--disable-component-update", "--disable-sync"]);
    browser.args(["--enable-logging=stderr", "--virtual-time-budget=5000", "--dump-dom"]);
    browser.arg(format!("--user-data-dir={}", profile.display()));
    browser.arg(format!("file://{}/{page}", place.path("").canonicalize().unwrap().display()));
    match browser.output() {
        Ok(output) => {
            let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
            Some((text(&output.stdout), text(&output.stderr)))
        }
        Err(error) => {
            eprintln!("chromium: {error}; nothing is tested");
            None
        }
    }
}

#[test]
fn a_replay_loads_scrubs_and_plays() {
    let place = Place::with_history(1);
    place.run("replay best --replication 0").done();
    let Some((document, said)) = visited(&place, "replay.html#trial=9&step=3") else { return };
    assert!(!said.contains("CONSOLE"), "{said}");
    assert!(document.contains("<span id=\"clock\">0.15 s</span>"), "{document}");
    assert!(document.contains("trial 9</title>"));
    let Some((document, said)) = visited(&place, "replay.html#trial=12&play") else { return };
    assert!(!said.contains("CONSOLE"), "{said}");
    // Trials of the small experiment have 8 steps.
    assert!(document.contains("<span id=\"clock\">0.40 s</span>"), "{document}");
    assert!(document.contains(">play</button>"), "it stops at the end");
}
