//! `selftalk history behaviours`: how each behaviour was learnt.

use selftalk_sim::{Behaviour, Simulator, TrialOutcome};

use super::args::BehaviourFilter;
use super::evaluate::{of, shares_of};
use super::output::Table;
use super::select;
use crate::exit::Failure;
use crate::retest::Tally;
use crate::store::{SqliteStore, StoredExperiment, StoredReplication};

/// Generations beside each other, and what the trials of their best individuals came to.
struct Bin {
    first: u32,
    last: u32,
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
            let mut outcomes = store.list_best_outcomes(replication.id).await?;
            // A master may have added more since.
            outcomes.retain(|(generation, _)| *generation < replication.generations);
            let bins = bins(&simulator, &outcomes, filter.bins);
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
fn bins(simulator: &Simulator, outcomes: &[(u32, Vec<TrialOutcome>)], count: u32) -> Vec<Bin> {
    let count = (count as usize).min(outcomes.len());
    let edge = |bin: usize| bin * outcomes.len() / count.max(1);
    let bin = |at: usize| {
        let generations = &outcomes[edge(at)..edge(at + 1)];
        let ((first, _), (last, _)) = (generations.first()?, generations.last()?);
        let trials: Vec<TrialOutcome> =
            generations.iter().flat_map(|(_, outcomes)| outcomes).copied().collect();
        Some(Bin { first: *first, last: *last, tally: Tally::of(simulator, &trials) })
    };
    (0..count).filter_map(bin).collect()
}

/// A line a bin.
fn lines(table: &mut Table, stored: &StoredExperiment, replication: &StoredReplication, bins: &[Bin]) {
    for Bin { first, last, tally } in bins {
        let mut row = vec![
            stored.experiment.name.as_str().into(),
            replication.number.into(),
            (*first).into(),
            (*last).into(),
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
    use selftalk_sim::Experiment;

    #[test]
    fn bins_hold_every_generation_once() {
        let simulator = Simulator::new(&Experiment::default()).unwrap();
        let success = TrialOutcome { score: 0.5, success: true, steps: 1 };
        let outcomes: Vec<_> = (0..23).map(|generation| (generation, vec![success; 16])).collect();
        for (asked, expected) in [(1, 1), (5, 5), (23, 23), (40, 23)] {
            let bins = bins(&simulator, &outcomes, asked);
            assert_eq!(bins.len(), expected);
            assert_eq!((bins[0].first, bins[expected - 1].last), (0, 22));
            assert!(bins.windows(2).all(|pair| pair[0].last + 1 == pair[1].first));
            assert_eq!(bins.iter().map(|bin| bin.tally.trials()).sum::<u32>(), 23 * 16);
        }
        assert!(bins(&simulator, &[], 5).is_empty());
    }

    #[test]
    fn blocks_are_as_high_as_shares() {
        assert_eq!([0.0, 0.5, 1.0, f64::NAN, 7.0].map(block), ['▁', '▅', '█', '▁', '█']);
    }
}
