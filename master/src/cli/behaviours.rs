//! `selftalk history behaviours`: how each behaviour was learnt.

use std::ops::RangeInclusive;

use selftalk_sim::{Behaviour, Simulator};

use super::args::BehaviourFilter;
use super::evaluate::{of, shares_of};
use super::output::Table;
use super::select;
use crate::exit::Failure;
use crate::retest::Tally;
use crate::store::{SqliteStore, StoredExperiment, StoredReplication};

/// Generations beside each other, and what the trials of their best individuals came to.
struct Bin {
    generations: RangeInclusive<u32>,
    tally: Tally,
}

pub(super) async fn behaviours(store: &SqliteStore, filter: &BehaviourFilter) -> Result<Table, Failure> {
    let mut table = if filter.curves {
        Table::new(["experiment", "replication", "behaviour", "successes", "first", "last", "score"])
    } else {
        Table::new([
            "experiment",
            "replication",
            "first",
            "last",
            "reach",
            "open",
            "grasp",
            "move",
            "move_to_target",
            "all",
            "reach_score",
            "open_score",
            "grasp_score",
            "move_score",
            "move_to_target_score",
        ])
    };
    for stored in select::replications(store, &filter.of).await? {
        let simulator = Simulator::new(&stored.experiment)?;
        for replication in &stored.replications {
            let edges: Vec<_> = edges(replication.generations, filter.bins).collect();
            let sums = store.sum_behaviours(replication.id, simulator.behaviours(), &edges).await?;
            let bin = |(generations, sums): (_, Vec<_>)| {
                let mut tally = Tally::default();
                sums.iter().for_each(|sum| tally.add(sum));
                Bin { generations, tally }
            };
            let bins: Vec<Bin> = edges.into_iter().zip(sums).map(bin).collect();
            if filter.curves {
                curves(&mut table, &stored, replication, &bins);
            } else {
                lines(&mut table, &stored, replication, &bins);
            }
        }
    }
    Ok(table)
}

/// As many bins as asked for, or as there are generations, none more than one generation longer than another.
fn edges(generations: u32, bins: u32) -> impl Iterator<Item = RangeInclusive<u32>> {
    let bins = bins.min(generations);
    // Less than `generations`, so it fits.
    let edge = move |bin: u32| (u64::from(bin) * u64::from(generations) / u64::from(bins.max(1))) as u32;
    (0..bins).map(move |bin| edge(bin)..=edge(bin + 1) - 1)
}

/// A line a bin.
fn lines(table: &mut Table, stored: &StoredExperiment, replication: &StoredReplication, bins: &[Bin]) {
    for Bin { generations, tally } in bins {
        let mut row = vec![
            stored.experiment.name.as_str().into(),
            replication.number.into(),
            (*generations.start()).into(),
            (*generations.end()).into(),
        ];
        row.extend(shares_of(tally));
        row.extend(Behaviour::ALL.map(|behaviour| of(tally, behaviour, Tally::score_of)));
        table.push(row);
    }
}

/// A line a behaviour.
fn curves(table: &mut Table, stored: &StoredExperiment, replication: &StoredReplication, bins: &[Bin]) {
    let (Some(first), Some(last)) = (bins.first(), bins.last()) else { return };
    for behaviour in Behaviour::ALL.into_iter().filter(|of| first.tally.trials_of(*of) > 0) {
        let curve: String = bins.iter().map(|bin| block(bin.tally.share_of(behaviour))).collect();
        table.push([
            stored.experiment.name.as_str().into(),
            replication.number.into(),
            behaviour.name().into(),
            curve.into(),
            first.tally.share_of(behaviour).into(),
            last.tally.share_of(behaviour).into(),
            last.tally.score_of(behaviour).into(),
        ]);
    }
}

/// A block as high as a share.
fn block(share: f64) -> char {
    const BLOCKS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    let at = (share * (BLOCKS.len() - 1) as f64).round() as usize;
    BLOCKS[at.min(BLOCKS.len() - 1)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_hold_every_generation_once() {
        for (asked, expected) in [(1, 1), (5, 5), (23, 23), (40, 23)] {
            let bins: Vec<_> = edges(23, asked).collect();
            assert_eq!(bins.len(), expected);
            assert!(bins.iter().cloned().flatten().eq(0..23));
            let lengths: Vec<usize> = bins.iter().map(|bin| bin.clone().count()).collect();
            assert!(lengths.iter().max().unwrap() - lengths.iter().min().unwrap() <= 1, "{lengths:?}");
        }
        assert_eq!(edges(0, 5).count(), 0);
    }

    #[test]
    fn blocks_are_as_high_as_shares() {
        assert_eq!([0.0, 0.5, 1.0, f64::NAN, 7.0].map(block), ['▁', '▅', '█', '▁', '█']);
    }
}
