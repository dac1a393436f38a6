//! From trial outcomes to the order in which individuals reproduce.

use selftalk_sim::{Behaviour, Simulator, TrialOutcome};

/// What an individual's trials add up to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scored {
    /// Fitness in [0, 1]; see [`score`].
    pub fitness: f64,
    /// Trials whose goal was reached.
    pub successes: u32,
}

/// The harmonic mean over the behaviours of their mean trial scores, and the number of successes.
///
/// `outcomes` are those of trials 0, 1, 2, ... A missing trial, or one whose score is not a finite number, counts as
/// score 0 and no success. Fitness is 0 as soon as one behaviour's mean is.
#[must_use]
pub fn score(simulator: &Simulator, outcomes: &[TrialOutcome]) -> Scored {
    let mut sums = [(0.0, 0_u32); Behaviour::ALL.len()];
    let mut successes = 0;
    for trial in 0..simulator.trial_count() {
        let (sum, trials) = &mut sums[simulator.behaviour(trial) as usize];
        *trials += 1;
        if let Some(outcome) = outcomes.get(trial as usize).filter(|outcome| outcome.score.is_finite()) {
            *sum += outcome.score;
            successes += u32::from(outcome.success);
        }
    }
    let means = sums.iter().filter(|(_, trials)| *trials > 0).map(|(sum, trials)| sum / f64::from(*trials));
    Scored { fitness: harmonic_mean(means), successes }
}

fn harmonic_mean(values: impl Iterator<Item = f64>) -> f64 {
    let (mut count, mut inverses) = (0_u32, 0.0);
    for value in values {
        if value <= 0.0 {
            return 0.0;
        }
        count += 1;
        inverses += value.recip();
    }
    if count == 0 { 0.0 } else { f64::from(count) / inverses }
}

/// The members' indices, the fittest first; of equally fit ones the lower index comes first.
#[must_use]
pub fn ranking(scored: &[Scored]) -> Vec<u32> {
    let mut order: Vec<(u32, f64)> = (0..).zip(scored.iter().map(|scored| scored.fitness)).collect();
    order.sort_by(|(_, a), (_, b)| b.total_cmp(a));
    order.into_iter().map(|(index, _)| index).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use selftalk_sim::Experiment;

    fn simulator() -> Simulator {
        Simulator::new(&Experiment::default())
    }

    /// Outcomes in which every trial of a behaviour has that behaviour's score.
    fn outcomes(scores: [f64; 4]) -> Vec<TrialOutcome> {
        let simulator = simulator();
        (0..simulator.trial_count())
            .map(|trial| TrialOutcome {
                score: scores[simulator.behaviour(trial) as usize],
                success: true,
                steps: 1,
            })
            .collect()
    }

    #[test]
    fn fitness_is_the_harmonic_mean_of_the_behaviours() {
        let scored = score(&simulator(), &outcomes([1.0, 0.5, 0.25, 0.125]));
        assert_eq!(scored, Scored { fitness: 4.0 / 15.0, successes: 16 });
    }

    #[test]
    fn a_behaviour_that_scores_nothing_spoils_all() {
        assert_eq!(score(&simulator(), &outcomes([1.0, 1.0, 0.0, 1.0])).fitness, 0.0);
    }

    #[test]
    fn unequal_trials_are_averaged_within_their_behaviour() {
        let mut all = outcomes([0.5; 4]);
        all[0].score = 0.9;
        all[1].score = 0.1;
        let scored = score(&simulator(), &all);
        assert!((scored.fitness - 0.5).abs() < 1e-15, "{scored:?}");
    }

    #[test]
    fn missing_and_non_finite_trials_count_nothing() {
        let simulator = simulator();
        let whole = score(&simulator, &outcomes([1.0; 4]));
        assert_eq!(whole, Scored { fitness: 1.0, successes: 16 });
        let mut all = outcomes([1.0; 4]);
        all[3].score = f64::NAN;
        all[15].score = f64::INFINITY;
        let spoilt = score(&simulator, &all);
        assert_eq!(spoilt.successes, 14);
        assert_eq!(spoilt.fitness, 4.0 / (2.0 + 2.0 / 0.75));
        assert_eq!(score(&simulator, &[]), Scored { fitness: 0.0, successes: 0 });
    }

    #[test]
    fn ties_go_to_the_lower_index() {
        let scored = [0.5, 0.7, 0.5, 0.0, 0.7].map(|fitness| Scored { fitness, successes: 0 });
        assert_eq!(ranking(&scored), [1, 4, 0, 2, 3]);
    }

    proptest! {
        #[test]
        fn a_ranking_is_an_ordered_permutation(fitness in prop::collection::vec(0.0_f64..1.0, 0..200)) {
            let scored: Vec<_> = fitness.into_iter().map(|fitness| Scored { fitness, successes: 0 }).collect();
            let order = ranking(&scored);
            prop_assert!(order.is_sorted_by(|&a, &b| scored[a as usize].fitness >= scored[b as usize].fitness));
            let mut sorted = order;
            sorted.sort_unstable();
            prop_assert!(sorted.into_iter().eq(0..scored.len() as u32));
        }

        #[test]
        fn fitness_lies_between_worst_and_best_behaviour(scores in prop::array::uniform4(0.0_f64..=1.0)) {
            let fitness = score(&simulator(), &outcomes(scores)).fitness;
            let worst = scores.into_iter().fold(1.0, f64::min);
            let best = scores.into_iter().fold(0.0, f64::max);
            prop_assert!((worst - 1e-12..=best + 1e-12).contains(&fitness), "{fitness}");
        }
    }
}
