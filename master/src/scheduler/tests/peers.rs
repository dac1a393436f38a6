//! Workers that are of no use, or worse.

use super::*;

#[test]
fn a_worker_that_fails_at_everything_takes_nothing_from_the_others() {
    let mut scheduler = Scheduler::default();
    scheduler.handle(joined(1, 1, 1, vec![]));
    scheduler.handle(joined(2, 2, 1, vec![]));
    scheduler.handle(Event::Submitted((0..40).map(work).collect()));
    let (mut effects, mut evaluated) = (scheduler.settle(), 0);
    while !effects.is_empty() {
        for effect in std::mem::take(&mut effects) {
            match effect {
                Effect::Lease(peer, units) => units.iter().for_each(|(work, _)| {
                    scheduler.handle(match peer {
                        PeerId(1) => Event::Failed(peer, work.key, "no memory".to_owned()),
                        _ => answered(peer, work.key),
                    });
                }),
                Effect::Ended(_, Verdict::Evaluated { .. }) => evaluated += 1,
                other => panic!("{other:?}"),
            }
        }
        effects = scheduler.settle();
    }
    assert_eq!(evaluated, 40);
    // Alone it is asked again and again, and not for ever.
    scheduler.handle(Event::Left(PeerId(2)));
    scheduler.handle(Event::Submitted(vec![work(99)]));
    for attempt in 1..=5 {
        assert_eq!(leases(&scheduler.settle()), [(1, vec![key(99)])], "attempt {attempt}");
        scheduler.handle(Event::Failed(PeerId(1), key(99), "no memory".to_owned()));
    }
    let verdict = Verdict::SetAside { losses: 5, reason: Some("no memory".to_owned()) };
    assert_eq!(scheduler.settle(), [Effect::Ended(key(99), verdict)]);
}

#[test]
fn a_worker_that_floods_is_cut_off_and_its_units_go_to_others() {
    let (mut scheduler, _) = scheduler(vec![joined(1, 1, 1, vec![]), Event::Submitted(vec![work(0)])]);
    scheduler.handle(joined(2, 2, 1, vec![]));
    let Limits { useless, useless_a_second, .. } = Limits::default();
    // As many as are borne with, and what a second makes up for.
    (0..useless).for_each(|_| scheduler.handle(Event::Heard(PeerId(1))));
    scheduler.handle(Event::Tick(1_000));
    (0..useless_a_second).for_each(|_| scheduler.handle(answered(PeerId(1), key(77))));
    assert_eq!(scheduler.settle(), []);
    scheduler.handle(Event::Heard(PeerId(1)));
    let effects = scheduler.settle();
    assert_eq!(effects[0], Effect::Disconnect(PeerId(1), Cut::Flooding));
    assert_eq!(leases(&effects), [(2, vec![key(0)])]);
    assert!(!scheduler.open[&key(0)].suspect(), "it has not killed the worker");
}

#[test]
fn workers_that_hang_cannot_keep_a_unit_among_themselves() {
    let (mut scheduler, _) = scheduler(vec![joined(1, 1, 1, vec![]), Event::Submitted(vec![work(0)])]);
    scheduler.handle(joined(2, 2, 1, vec![]));
    let beat = |scheduler: &mut Scheduler, now_ms| {
        (1..=3).for_each(|peer| scheduler.handle(Event::Heard(PeerId(peer))));
        scheduler.handle(Event::Tick(now_ms));
        leases(&scheduler.settle())
    };
    assert_eq!(beat(&mut scheduler, 3_001), [(2, vec![key(0)])]);
    scheduler.handle(joined(3, 3, 1, vec![]));
    assert_eq!(beat(&mut scheduler, 9_001), []);
    assert_eq!(beat(&mut scheduler, 9_002), [(3, vec![key(0)])]);
}

#[test]
fn a_slow_machine_does_not_hang() {
    let (mut scheduler, _) =
        scheduler(vec![joined(1, 1, 1, vec![]), Event::Submitted((0..5).map(work).collect())]);
    // Others take a minute for a unit and it takes more: they evaluate all that it was given.
    (2..=9).for_each(|peer| scheduler.handle(joined(peer, peer, 1, vec![])));
    let mut cut = false;
    for now_ms in (0..70_000).step_by(1_000) {
        (1..=9).for_each(|peer| scheduler.handle(Event::Heard(PeerId(peer))));
        scheduler.handle(Event::Tick(now_ms));
        cut |= scheduler.settle().iter().any(|effect| matches!(effect, Effect::Disconnect(..)));
    }
    let doubled: Vec<_> = (0..5).filter(|unit| scheduler.open[&key(*unit)].holders.len() > 1).collect();
    assert_eq!(doubled.len(), 5);
    (0..5).for_each(|unit| scheduler.handle(answered(PeerId(2), key(unit))));
    cut |= scheduler.settle().iter().any(|effect| matches!(effect, Effect::Disconnect(..)));
    assert!(!cut && scheduler.open_units() == 0);
}

/// Worker 2 answers at once whatever it is given; why worker 1 was cut off, if it was.
fn answer_all(scheduler: &mut Scheduler) -> Option<Cut> {
    let mut cut = None;
    for effect in scheduler.settle() {
        match effect {
            Effect::Lease(PeerId(2), leased) => {
                leased.iter().for_each(|(work, _)| scheduler.handle(answered(PeerId(2), work.key)));
            }
            Effect::Disconnect(PeerId(1), why) => cut = Some(why),
            _ => {}
        }
    }
    cut
}

#[test]
fn a_worker_that_hangs_is_found_out_while_there_is_more_to_do() {
    let mut scheduler = Scheduler::default();
    scheduler.handle(joined(1, 1, 1, vec![]));
    scheduler.handle(joined(2, 2, 1, vec![]));
    let (mut units, mut now_ms, mut cut) = (0, 0, None);
    while cut.is_none() && now_ms < 120_000 {
        scheduler.handle(Event::Submitted((units..units + 200).map(work).collect()));
        units += 200;
        cut = answer_all(&mut scheduler);
        now_ms += 500;
        scheduler.handle(Event::Heard(PeerId(1)));
        scheduler.handle(Event::Heard(PeerId(2)));
        scheduler.handle(Event::Tick(now_ms));
    }
    assert_eq!(cut, Some(Cut::Hanging));
    assert!((30_000..40_000).contains(&now_ms), "{now_ms}");
}

#[test]
fn what_waits_in_a_workers_queue_does_not_make_it_slow() {
    let mut scheduler = Scheduler::default();
    scheduler.handle(joined(1, 1, 1, vec![]));
    scheduler.handle(joined(2, 2, 1, vec![]));
    let (mut units, mut now_ms, mut cut) = (0, 0, None);
    let mut queue = VecDeque::new();
    while cut.is_none() && now_ms < 300_000 {
        scheduler.handle(Event::Submitted((units..units + 10).map(work).collect()));
        units += 10;
        for effect in scheduler.settle() {
            match effect {
                Effect::Lease(PeerId(2), leased) => queue.extend(leased.iter().map(|(work, _)| work.key)),
                Effect::Disconnect(PeerId(1), why) => cut = Some(why),
                _ => {}
            }
        }
        now_ms += 1_000;
        scheduler.handle(Event::Heard(PeerId(1)));
        scheduler.handle(Event::Tick(now_ms));
        // A second for a unit, ten of which are queued or more.
        if let Some(key) = queue.pop_front() {
            scheduler.handle(answered(PeerId(2), key));
        }
    }
    assert_eq!(cut, Some(Cut::Hanging));
    assert!((30_000..60_000).contains(&now_ms), "{now_ms}");
}

#[test]
fn a_worker_that_hangs_is_given_nothing_more() {
    let mut scheduler = Scheduler::default();
    scheduler.handle(joined(1, 1, 1, vec![]));
    scheduler.handle(joined(2, 2, 1, vec![]));
    let (mut units, mut now_ms, mut cut) = (0, 0, None);
    while cut.is_none() {
        scheduler.handle(Event::Submitted((units..units + 20).map(work).collect()));
        units += 20;
        while scheduler.open_units() > 0 {
            cut = cut.or(answer_all(&mut scheduler));
            now_ms += 500;
            scheduler.handle(Event::Heard(PeerId(1)));
            scheduler.handle(Event::Heard(PeerId(2)));
            scheduler.handle(Event::Tick(now_ms));
        }
    }
    assert_eq!(cut, Some(Cut::Hanging));
    assert!((30_000..40_000).contains(&now_ms), "{now_ms}");
    scheduler.handle(joined(3, 1, 1, vec![]));
    assert!(scheduler.settle().contains(&Effect::Disconnect(PeerId(3), Cut::Hanging)));
}
