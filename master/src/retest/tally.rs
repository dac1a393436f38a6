//! What trials add up to, by behaviour.

use std::sync::Arc;

use selftalk_sim::{Behaviour, Draw, Genotype, Simulator, TrialOutcome};

use super::RetestError;
use super::batch::{Crew, Task, run};
use crate::store::BehaviourSummary;

/// Trials, successes and scores, by behaviour.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Tally {
    trials: [u32; Behaviour::ALL.len()],
    successes: [u32; Behaviour::ALL.len()],
    scores: [f64; Behaviour::ALL.len()],
}

impl Tally {
    /// Of outcomes of trials 0, 1, 2, ..., again and again.
    #[must_use]
    pub fn of(simulator: &Simulator, outcomes: &[TrialOutcome]) -> Self {
        let mut tally = Self::default();
        for (trial, outcome) in (0..simulator.trial_count()).cycle().zip(outcomes) {
            let behaviour = simulator.behaviour(trial) as usize;
            tally.trials[behaviour] += 1;
            tally.successes[behaviour] += u32::from(outcome.success);
            tally.scores[behaviour] += if outcome.score.is_finite() { outcome.score } else { 0.0 };
        }
        tally
    }

    /// Adds trials of a behaviour.
    pub fn add(&mut self, of: &BehaviourSummary) {
        let behaviour = of.behaviour as usize;
        self.trials[behaviour] += of.trials;
        self.successes[behaviour] += of.successes;
        self.scores[behaviour] += of.score * f64::from(of.trials);
    }

    /// Trials of all behaviours.
    #[must_use]
    pub fn trials(&self) -> u32 {
        self.trials.iter().sum()
    }

    /// Successes of all behaviours.
    #[must_use]
    pub fn successes(&self) -> u32 {
        self.successes.iter().sum()
    }

    /// Trials of a behaviour.
    #[must_use]
    pub const fn trials_of(&self, behaviour: Behaviour) -> u32 {
        self.trials[behaviour as usize]
    }

    /// Successes of a behaviour.
    #[must_use]
    pub const fn successes_of(&self, behaviour: Behaviour) -> u32 {
        self.successes[behaviour as usize]
    }

    /// Share of the trials of a behaviour that succeeded; 0 without any.
    #[must_use]
    pub fn share_of(&self, behaviour: Behaviour) -> f64 {
        share(self.successes_of(behaviour).into(), self.trials_of(behaviour))
    }

    /// Share of all trials that succeeded; 0 without any.
    #[must_use]
    pub fn share(&self) -> f64 {
        share(self.successes().into(), self.trials())
    }

    /// Mean score of the trials of a behaviour; 0 without any.
    #[must_use]
    pub fn score_of(&self, behaviour: Behaviour) -> f64 {
        share(self.scores[behaviour as usize], self.trials_of(behaviour))
    }
}

fn share(sum: f64, trials: u32) -> f64 {
    if trials == 0 { 0.0 } else { sum / f64::from(trials) }
}

/// Runs all trials of genotypes in each of the draws, and adds up those of each genotype.
///
/// # Errors
/// [`RetestError`] when a genotype does not fit the experiment.
pub fn tallies(
    simulator: &Simulator,
    genotypes: &[Arc<Genotype>],
    draws: &[Draw],
    crew: Crew<'_>,
) -> Result<Vec<Tally>, RetestError> {
    let tasks: Vec<Task> = genotypes
        .iter()
        .flat_map(|genotype| draws.iter().flat_map(|draw| Task::all(simulator, genotype, *draw)))
        .collect();
    let outcomes = run(simulator, &tasks, crew)?;
    let each = (draws.len() * simulator.trial_count() as usize).max(1);
    Ok(outcomes.chunks(each).map(|outcomes| Tally::of(simulator, outcomes)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use selftalk_sim::Experiment;

    #[test]
    fn outcomes_count_for_their_behaviour() {
        let simulator = Simulator::new(&Experiment::default()).unwrap();
        let outcomes: Vec<TrialOutcome> = (0..32)
            .map(|i| TrialOutcome { score: f64::from(i), success: i % 4 == 0 || i >= 28, steps: 1 })
            .collect();
        let tally = Tally::of(&simulator, &outcomes);
        assert_eq!((tally.trials(), tally.successes()), (32, 11));
        assert_eq!(
            Behaviour::ELEMENTARY.map(|behaviour| tally.share_of(behaviour)),
            [0.25, 0.25, 0.25, 5.0 / 8.0]
        );
        assert_eq!(tally.score_of(Behaviour::Reach), 9.5);
        assert_eq!(Tally::default().share(), 0.0);
    }
}
