//! How many units are given out at once.

use super::*;

#[test]
fn work_is_spread_and_batches_shrink() {
    let (_, effects) = scheduler(vec![
        joined(1, 1, 1, vec![]),
        joined(2, 2, 1, vec![]),
        Event::Submitted((0..20).map(work).collect()),
    ]);
    let sizes: Vec<(u64, usize)> =
        leases(&effects).into_iter().map(|(peer, units)| (peer, units.len())).collect();
    assert_eq!(sizes, [(1, 2), (2, 2), (1, 2), (2, 1)]);
}

#[test]
fn fast_workers_are_given_more_at_once() {
    let (mut scheduler, effects) =
        scheduler(vec![joined(1, 1, 1, vec![]), Event::Submitted((0..900).map(work).collect())]);
    let mut held: VecDeque<UnitKey> = leases(&effects).into_iter().flat_map(|(_, units)| units).collect();
    let mut largest = Vec::new();
    for (now_ms, answers) in [(250, 250), (500, 250), (750, 0), (1000, 0), (2000, 340)] {
        let mut sizes = vec![0];
        for _ in 0..answers {
            let key = held.pop_front().unwrap();
            scheduler.handle(answered(PeerId(1), key));
            for (_, units) in leases(&scheduler.settle()) {
                sizes.push(units.len());
                held.extend(units);
            }
        }
        scheduler.handle(Event::Tick(now_ms));
        largest.push(sizes.into_iter().max());
    }
    // A thousand a second, which are 25 in 25 ms; no worker is slow by having had nothing to do for a moment.
    assert_eq!(largest, [4, 25, 0, 0, 6].map(Some));
}
