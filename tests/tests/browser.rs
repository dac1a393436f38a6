//! Pages in a real browser: Chromium without a window. Without Chromium (`apt install chromium`) nothing is tested here.

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

#[cfg(unix)]
mod dashboard {
    use selftalk_tests::{Browser, Page, Place, wait_until};

    #[test]
    fn curves_grow_while_somebody_looks() {
        let Some(mut browser) = Browser::start() else { return };
        let place = Place::new();
        let mut run =
            place.start("run small.toml --workers 1 --set generations=100000 --dashboard 127.0.0.1:0");
        let address = run.dashboard();
        wait_until("it is ready", || (Page::get(&address, "/readyz").status == 200).then_some(()));
        browser.go(&format!("http://{address}/"));
        let points = "Number(document.querySelector('.chart .line')?.dataset.points ?? 0)";
        browser.wait(&format!("{points} >= 2"));
        browser.eval("globalThis.stays = document.querySelector('.cell')");
        browser.eval(&format!("globalThis.before = {points}"));
        browser.wait(&format!("{points} >= before + 3"));
        assert_eq!(browser.eval("stays.isConnected && stays === document.querySelector('.cell')"), true);
        browser.wait("document.getElementById('status').textContent.startsWith('1 worker · about ')");
        browser
            .wait("document.querySelector('section[aria-labelledby=workers] tbody tr').cells.length === 7");

        // By keyboard: a value is read off a curve, a replication is opened and followed.
        browser.eval("document.querySelector('.chart svg').focus()");
        browser.press("Home");
        browser.wait("document.querySelector('.chart .says').textContent.startsWith('generation 0')");
        browser.eval("document.querySelector('.cell').focus()");
        browser.eval("document.activeElement.click()");
        browser.wait("location.pathname === '/experiments/small/0' && document.activeElement.id === 'main'");
        let heading = "document.getElementById('individuals').textContent";
        browser.wait(&format!("{heading}.endsWith(', the last')"));
        browser.eval(&format!("globalThis.before = {heading}"));
        browser.wait(&format!("{heading}.endsWith(', the last') && {heading} !== before"));
        browser.assert_content();

        // It says so when the run is gone.
        assert!(run.kill());
        browser.wait("document.getElementById('status').className === 'lost'");
    }

    #[test]
    fn an_individual_is_found_and_replayed() {
        let Some(mut browser) = Browser::start() else { return };
        let place = Place::with_history(3);
        let mut dashboard = place.start("dashboard --listen 127.0.0.1:0");
        let address = dashboard.dashboard();
        browser.narrow(360);
        browser.prefer("dark");
        for page in ["", "experiments/small", "experiments/small/1", "experiments/small/1/1/4"] {
            browser.go(&format!("http://{address}/{page}"));
            browser
                .wait("document.documentElement.dataset.state === 'shown' && document.querySelector('h1')");
            assert_eq!(browser.eval("document.documentElement.scrollWidth"), 360, "{page} fits a phone");
            assert_eq!(browser.eval("document.querySelectorAll('h1, main, nav').length"), 3, "{page}");
        }
        browser.go(&format!("http://{address}/"));
        browser.wait("document.querySelector('#status').textContent.startsWith('no master is running')");
        browser.wait("document.querySelectorAll('.cell.finished').length === 2");
        browser.eval("document.querySelectorAll('.cell')[1].click()");
        browser.wait(
            "document.querySelectorAll('tbody tr').length === 20 && document.querySelector('table caption')",
        );
        browser.eval("[...document.querySelectorAll('tbody a')].find((link) => link.textContent === 'lineage').click()");
        browser.wait("document.querySelectorAll('.trials li').length === 16");
        browser.wait("document.querySelector('#lineage').parentElement.textContent.includes('founder')");
        browser.eval("history.back()");
        browser.wait("location.pathname === '/experiments/small/1'");
        browser.eval("history.forward()");
        browser.wait("document.querySelector('a.main')?.textContent === 'Replay its trials'");
        browser.eval("document.querySelector('a.main').click()");

        // Trials of the small experiment have 8 steps.
        let clock = "document.getElementById('clock').textContent";
        browser.wait(&format!("{clock} === '0.00 s' && location.pathname.endsWith('/replay')"));
        browser.eval("document.getElementById('play').click()");
        browser
            .wait(&format!("{clock} === '0.40 s' && document.getElementById('play').textContent === 'play'"));
        browser.press("ArrowLeft");
        browser.wait(&format!("{clock} === '0.35 s'"));
        browser.eval("const time = document.getElementById('time'); time.value = 3; time.dispatchEvent(new Event('input'))");
        browser.wait(&format!("{clock} === '0.15 s'"));
        browser.assert_content();
    }
}
