//! The history of an experiment is the same however the run went.
//!
//! That it is also the same in debug and in release builds follows from running these tests with both, as CI does: they
//! all compare with one constant.

use selftalk_tests::{GOLDEN, Place, Running, free_port, wait_until};

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
    let place = Place::disturbed(|place| {
        let (master, address) = serve(place);
        let workers = [(); 3].map(|()| place.start_worker(&address));
        master.end().done();
        let mut expected = workers.each_ref().map(Running::id);
        expected.sort_unstable();
        let mut took_part = processes(place);
        took_part.sort_unstable();
        if took_part != expected {
            return false;
        }
        for worker in workers {
            worker.end().done();
        }
        true
    });
    assert_eq!(place.digests(), GOLDEN);
}

#[test]
fn a_worker_killed_half_way() {
    let place = Place::disturbed(|place| {
        let (master, address) = serve(place);
        let first = place.start_worker(&address);
        place.wait_half_way();
        if !first.kill() || !place.is_half_way() {
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
    let place = Place::disturbed(|place| {
        let master = place.start("run small.toml --workers 2");
        place.wait_half_way();
        master.kill() && place.is_half_way()
    });
    place.run("resume small --workers 2").done();
    assert_eq!(place.generations(), 24);
    assert_eq!(place.digests(), GOLDEN);
}

#[test]
fn a_master_killed_half_way_and_restarted_for_the_same_workers() {
    let listen = format!("serve --listen 127.0.0.1:{} small.toml", free_port());
    let place = Place::disturbed(|place| {
        let mut master = place.start(&listen);
        let address = master.address();
        let mut workers = [(); 2].map(|()| place.start_worker(&address));
        if !workers.iter_mut().all(|worker| worker.reports("connected master=")) {
            return false;
        }
        place.wait_half_way();
        if !master.kill() || !place.is_half_way() {
            return false;
        }
        assert!(workers.iter_mut().all(|worker| worker.reports("not connected")));
        place.start(&listen).end().done();
        // One of them may have been between two attempts for as long as that took.
        let (expected, all) = (workers.each_ref().map(Running::id), processes(place));
        assert!(all.len() > 2 && all.iter().all(|process| expected.contains(process)), "{all:?}");
        true
    });
    assert_eq!(place.digests(), GOLDEN);
}

/// The slow engine, with all that is small made smaller.
const IN_RAPIER: &str = "--set engine=rapier --set replications=1 --set generations=3 --set evolution.population=2 \
    --set evolution.parents=1 --set evolution.offspring=2 --set reach.steps=3 --set open.steps=3 --set grasp.steps=3 \
    --set move.steps=3 --set physics.substeps=4";

#[test]
fn another_engine_killed_and_resumed() {
    let place = Place::disturbed(|place| {
        let master = place.start(&format!("run small.toml {IN_RAPIER} --workers 2"));
        wait_until("a generation", || (place.generations() >= 1).then_some(()));
        master.kill() && place.generations() < 3
    });
    place.run("resume small --workers 1").done();
    assert_eq!(place.generations(), 3);
    let resumed = place.digests();
    let place = Place::new();
    place.run(&format!("run small.toml {IN_RAPIER} --workers 2")).done();
    assert_eq!(place.digests(), resumed);
}
