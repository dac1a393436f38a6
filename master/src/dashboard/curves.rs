//! Learning curves, thinned out to what can be drawn, and only what is new.

use serde::Serialize;

use super::answer::{Refusal, rounded};
use super::sources::Sources;
use crate::store::{CurvePoint, StoredExperiment};

/// Points of a curve at most, beside its last.
const POINTS: u32 = 500;

/// The curves of an experiment's replications.
#[derive(Debug, PartialEq, Serialize)]
pub(super) struct Curves {
    /// Generations from one point to the next: a power of two, so that when it doubles every other point goes.
    stride: u32,
    replications: Vec<Curve>,
}

/// One replication's curve, column by column. Its last point is always there and need not be a multiple of the stride.
#[derive(Debug, PartialEq, Serialize)]
struct Curve {
    number: u32,
    generation: Vec<u32>,
    best: Vec<f64>,
    mean: Vec<f64>,
    successes: Vec<u32>,
    optimal: Vec<u32>,
}

/// The curves from a generation on.
pub(super) async fn curves(
    sources: &Sources,
    stored: &StoredExperiment,
    since: u32,
) -> Result<Curves, Refusal> {
    let most = stored.replications.iter().map(|replication| replication.generations).max();
    let stride = stride(most.unwrap_or_default());
    let mut replications = Vec::with_capacity(stored.replications.len());
    for replication in &stored.replications {
        let points = sources.store().list_curve(replication.id, since, stride).await?;
        replications.push(Curve::new(replication.number, &points));
    }
    Ok(Curves { stride, replications })
}

fn stride(generations: u32) -> u32 {
    generations.div_ceil(POINTS).max(1).next_power_of_two()
}

impl Curve {
    fn new(number: u32, points: &[CurvePoint]) -> Self {
        Self {
            number,
            generation: points.iter().map(|point| point.generation).collect(),
            best: points.iter().map(|point| rounded(point.best_fitness)).collect(),
            mean: points.iter().map(|point| rounded(point.mean_fitness)).collect(),
            successes: points.iter().map(|point| point.best_successes).collect(),
            optimal: points.iter().map(|point| point.optimal_individuals).collect(),
        }
    }
}

#[cfg(test)]
mod stride {
    use super::*;

    #[test]
    fn a_curve_has_between_half_as_many_points_as_allowed_and_all_of_them() {
        assert_eq!([0, 1, 500, 501, 1000, 1001, 1500].map(stride), [1, 1, 1, 2, 2, 4, 4]);
        for generations in [501, 777, 5000, 100_000] {
            let points = generations / stride(generations);
            assert!((POINTS / 2..=POINTS).contains(&points), "{generations}: {points}");
        }
    }
}
