//! Why an individual fails, over many draws of the same trial.

use std::collections::BTreeMap;

use selftalk_sim::behaviours::Quantity;
use selftalk_sim::{Case, Draw, Experiment, Genotype, Simulator};

use super::RetestError;
use super::course::Course;
use super::words::{directions, number};

/// What came of a trial in many draws.
#[derive(Debug, Clone, PartialEq)]
pub struct Why {
    /// Draws in which it was run.
    pub trials: u32,
    /// Those in which it succeeded.
    pub successes: u32,
    /// Mean score.
    pub score: f64,
    /// Mean share of the control steps in which attention was on what the behaviour is about.
    pub focus: f64,
    /// In words how the others failed, the most frequent first.
    pub reasons: String,
}

/// Failures of a kind.
#[derive(Debug, Default)]
struct Kind {
    count: usize,
    /// The best that each lacking quantity came to.
    bests: BTreeMap<Quantity, Vec<f64>>,
    /// In which directions distances were too long at their best.
    misses: BTreeMap<Quantity, Vec<[f64; 3]>>,
    shoved: usize,
    dropped: usize,
}

/// Runs a trial in many draws and says how it fails.
///
/// # Errors
/// [`RetestError`] when genotype or trial do not fit the experiment.
pub fn why(
    experiment: &Experiment,
    simulator: &Simulator,
    genotype: &Genotype,
    draws: &[Draw],
    trial: u32,
) -> Result<Why, RetestError> {
    let mut kinds: BTreeMap<String, Kind> = BTreeMap::new();
    let mut why = Why { trials: 0, successes: 0, score: 0.0, focus: 0.0, reasons: String::new() };
    for draw in draws {
        let trace = simulator.trace(genotype, Case::Drawn { draw: *draw, trial })?;
        let course = Course::new(experiment, simulator.behaviour(trial), &trace);
        why.trials += 1;
        why.score += trace.outcome.score;
        why.focus += course.focus();
        if trace.outcome.success {
            why.successes += 1;
            continue;
        }
        let lacking = course.lacking();
        let kind = kinds.entry(kind(&course, &lacking)).or_default();
        kind.count += 1;
        kind.shoved += usize::from(course.shoved().is_some());
        kind.dropped += usize::from(course.dropped().is_some());
        for quantity in lacking {
            kind.bests.entry(quantity).or_default().extend(course.best(quantity).map(|(_, best)| best.value));
            kind.misses.entry(quantity).or_default().extend(course.miss(quantity));
        }
    }
    let count = f64::from(why.trials.max(1));
    (why.score, why.focus) = (why.score / count, why.focus / count);
    let mut kinds: Vec<(String, Kind)> = kinds.into_iter().collect();
    kinds.sort_by_key(|(_, kind)| std::cmp::Reverse(kind.count));
    why.reasons = kinds.iter().map(|(name, kind)| kind.words(name)).collect::<Vec<_>>().join("; ");
    Ok(why)
}

fn kind(course: &Course<'_>, lacking: &[Quantity]) -> String {
    if course.held() > 0 {
        "goal not held for long enough".to_owned()
    } else if lacking.is_empty() {
        "conditions never together".to_owned()
    } else {
        let names: Vec<&str> = lacking.iter().map(|quantity| quantity.name()).collect();
        format!("never {}", names.join(" and "))
    }
}

impl Kind {
    fn words(&self, name: &str) -> String {
        let mut words = vec![format!("{}x {name}", self.count)];
        for (quantity, bests) in &self.bests {
            let misses = self.misses.get(quantity).map(Vec::as_slice).unwrap_or_default();
            let miss =
                std::array::from_fn(|axis| median(misses.iter().map(|miss| miss[axis])).unwrap_or(0.0));
            if let Some(best) = median(bests.iter().copied()) {
                let ways = directions(miss);
                let ways = if ways.is_empty() { ways } else { format!(" ({ways})") };
                words.push(format!("{} {}{ways} at best", quantity.name(), number(*quantity, best)));
            }
        }
        for (count, what) in [(self.shoved, "object pushed"), (self.dropped, "object dropped")] {
            if count > 0 {
                words.push(format!("{count}x {what}"));
            }
        }
        words.join(", ")
    }
}

/// The lower of the middle ones.
fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len().checked_sub(1)? / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_the_middle() {
        assert_eq!(median([3.0, 1.0, 2.0].into_iter()), Some(2.0));
        assert_eq!(median([3.0, 1.0, 2.0, 4.0].into_iter()), Some(2.0));
        assert_eq!(median(std::iter::empty()), None);
    }

    #[test]
    fn failures_add_up_to_the_trials_that_are_no_success() {
        let mut experiment = Experiment::default();
        experiment.reach.steps = 3;
        let simulator = Simulator::new(&experiment).unwrap();
        let genotype = Genotype::new(vec![30_000; simulator.gene_count()]);
        let draws: Vec<Draw> = (0..5).map(Draw::test).collect();
        let why = why(&experiment, &simulator, &genotype, &draws, 1).unwrap();
        assert_eq!((why.trials, why.successes), (5, 0));
        assert!(why.reasons.starts_with("5x never palm to top, palm to top 0."), "{why:?}");
        assert!(why.reasons.contains(" too "), "{why:?}");
    }
}
