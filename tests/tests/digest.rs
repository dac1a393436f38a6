//! The history of an experiment is the same however the run went.
//!
//! That it is also the same in debug and in release builds follows from running these tests in both, as CI does: they
//! all compare with one constant.

// Helpers of tests are test code as well, though the compiler cannot know it.
#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used)]

use selftalk_tests::{GOLDEN, Place, Running, free_port, wait_until};

/// Whether a run ends before a test could disturb it is a matter of luck on a busy machine.
const ATTEMPTS: u32 = 5;

/// Gives a new place to `disturb` until it could do its work in the middle of a run.
fn half_way(disturb: impl Fn(&Place) -> bool) -> Place {
    let places = std::iter::repeat_with(Place::new).take(ATTEMPTS as usize);
    places.into_iter().find(|place| disturb(place)).expect("a run that takes long enough to be disturbed")
}

/// A master that waits for workers, and its address.
fn serve(place: &Place) -> (Running, String) {
    let mut master = place.start("serve --listen 127.0.0.1:0 small.toml");
    let address = master.address();
    (master, address)
}

/// Processes of the workers that took part, according to the history.
fn processes(place: &Place) -> Vec<u32> {
    let workers = place.ask("history workers");
    workers.iter().map(|worker| worker["process"].as_u64().unwrap() as u32).collect()
}

#[test]
fn one_worker() {
    let place = Place::new();
    place.run("run small.toml --workers 1").done();
    assert_eq!(place.digests(), GOLDEN);
}

#[test]
fn three_workers() {
    let place = Place::new();
    place.run("run small.toml --workers 3").done();
    assert_eq!(place.ask("history workers").len(), 3);
    assert_eq!(place.digests(), GOLDEN);
}

#[test]
fn another_seed_gives_another_history() {
    let place = Place::new();
    place.run("run small.toml --seed 8 --set generations=1").done();
    let seed_8 = place.digests();
    let place = Place::new();
    place.run("run small.toml --set generations=1").done();
    let seed_7 = place.digests();
    assert!(seed_7[0] != seed_8[0] && seed_7[1] != seed_8[1] && seed_7[0] != seed_7[1]);
}

#[test]
fn three_worker_processes() {
    let place = Place::new();
    let (master, address) = serve(&place);
    let workers = [(); 3].map(|()| place.start_worker(&address));
    let mut expected = workers.each_ref().map(Running::id);
    master.end().done();
    for worker in workers {
        worker.end().done();
    }
    let mut took_part = processes(&place);
    took_part.sort_unstable();
    expected.sort_unstable();
    assert_eq!(took_part, expected);
    assert_eq!(place.digests(), GOLDEN);
}

#[test]
fn a_worker_killed_half_way() {
    let place = half_way(|place| {
        let (mut master, address) = serve(place);
        let first = place.start_worker(&address);
        place.wait_half_way();
        if !master.is_running() {
            return false;
        }
        first.kill();
        if place.is_finished() {
            return false;
        }
        let second = place.start_worker(&address);
        master.end().done();
        second.end().done();
        true
    });
    assert_eq!(processes(&place).len(), 2);
    assert_eq!(place.digests(), GOLDEN);
}

#[test]
fn a_master_killed_half_way_and_resumed() {
    let place = half_way(|place| {
        let mut master = place.start("run small.toml --workers 2");
        place.wait_half_way();
        if !master.is_running() {
            return false;
        }
        master.kill();
        !place.is_finished()
    });
    let before = place.generations();
    assert!((2..24).contains(&before), "{before}");
    place.run("resume small --workers 2").done();
    assert_eq!(place.generations(), 24);
    assert_eq!(place.digests(), GOLDEN);
}

#[test]
fn a_master_killed_half_way_and_restarted_for_the_same_workers() {
    let listen = format!("serve --listen 127.0.0.1:{} small.toml", free_port());
    let place = half_way(|place| {
        let mut master = place.start(&listen);
        let address = master.address();
        let mut workers = [(); 2].map(|()| place.start_worker(&address));
        place.wait_half_way();
        if !master.is_running() {
            return false;
        }
        master.kill();
        if place.is_finished() {
            return false;
        }
        for worker in &mut workers {
            wait_until("the worker notices", || worker.reported().contains("not connected").then_some(()));
            assert!(worker.is_running());
        }
        let expected = workers.each_ref().map(Running::id);
        let master = place.start(&listen);
        master.end().done();
        for worker in workers {
            worker.end().done();
        }
        let all = processes(place);
        assert!(all.len() == 4 && all.iter().all(|process| expected.contains(process)), "{all:?}");
        true
    });
    assert_eq!(place.digests(), GOLDEN);
}
