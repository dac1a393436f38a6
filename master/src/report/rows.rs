//! The lines of a report's tables.

use selftalk_sim::TrialOutcome;
use serde::Serialize;

use super::{Condition, Study, percent};
use crate::statistics::{MannWhitney, holm, mann_whitney, median};

/// A line of `summary.csv`: the best robot of a replication.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SummaryRow {
    /// Its condition.
    pub condition: String,
    /// Its replication.
    pub replication: u32,
    /// Its generation.
    pub best_generation: u32,
    /// Trials of post-evaluation that succeeded.
    pub post_successes_of_40: u32,
    /// Trials of generalisation that succeeded.
    pub generalisation_successes_of_196: u32,
}

/// A line of `robots.csv`: the genes of that robot.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RobotRow {
    /// Its condition.
    pub condition: String,
    /// Its experiment.
    pub experiment: String,
    /// Its replication.
    pub replication: u32,
    /// Its generation.
    pub generation: u32,
    /// Its number there.
    pub individual: u32,
    /// Four hexadecimal digits each.
    pub genes: String,
}

/// A line of `curves.csv`: the best individual of a generation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CurveRow {
    /// Its condition.
    pub condition: String,
    /// Its replication.
    pub replication: u32,
    /// Its generation.
    pub generation: u32,
    /// Its fitness.
    pub fitness: f64,
    /// Trials of 8 in which it succeeded in its own generation.
    pub successes_of_8: u32,
    /// Trials of post-evaluation that succeeded.
    pub post_successes_of_40: u32,
}

/// A line of `pairwise.csv`: two conditions compared by their robots.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PairRow {
    /// `post` or `generalisation`.
    pub test: String,
    /// The first condition.
    pub a: String,
    /// The second one.
    pub b: String,
    /// U of the first.
    pub u: f64,
    /// Two-tailed p-value.
    pub p: f64,
    /// Corrected for the pairs of the same test.
    pub p_holm: f64,
    /// Effect size: the probability that a robot of the first condition does better.
    pub a12: f64,
}

/// A line of `even_odd.csv`: a robot with the caretaker's labels, as in even trials, and with its own, as in odd ones.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AidRow {
    /// Its condition.
    pub condition: String,
    /// Its replication.
    pub replication: u32,
    /// Trials.
    pub trials: u32,
    /// Those that succeeded without the caretaker.
    pub own_successes: u32,
    /// Those that succeeded with it.
    pub aided_successes: u32,
    /// Two-tailed p-value of a Mann-Whitney U test between the trials' successes.
    pub p_successes: Option<f64>,
    /// Median length of the successful trials without it, control steps.
    pub own_steps_to_goal: Option<f64>,
    /// The same with it.
    pub aided_steps_to_goal: Option<f64>,
    /// Two-tailed p-value of a Mann-Whitney U test between these lengths.
    pub p_steps: Option<f64>,
}

/// What robots are compared by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Successes in post-evaluation.
    Post,
    /// Successes in generalisation.
    Generalisation,
}

impl Quantity {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Post, Self::Generalisation];

    /// Its name in the tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Post => "post",
            Self::Generalisation => "generalisation",
        }
    }

    /// Of each robot of a condition, in percent of its trials.
    #[must_use]
    pub fn of(self, condition: &Condition) -> Vec<f64> {
        let of = |robot: &super::Robot| match self {
            Self::Post => percent(&robot.post),
            Self::Generalisation => percent(&robot.generalisation),
        };
        condition.robots.iter().map(of).collect()
    }
}

fn successes(outcomes: &[TrialOutcome]) -> u32 {
    outcomes.iter().map(|outcome| u32::from(outcome.success)).sum()
}

pub(super) fn summary(study: &Study) -> Vec<SummaryRow> {
    let rows = study.conditions.iter().flat_map(|condition| {
        condition.robots.iter().map(|robot| SummaryRow {
            condition: condition.label.clone(),
            replication: robot.replication,
            best_generation: robot.generation,
            post_successes_of_40: successes(&robot.post),
            generalisation_successes_of_196: successes(&robot.generalisation),
        })
    });
    rows.collect()
}

pub(super) fn robots(study: &Study) -> Vec<RobotRow> {
    let rows = study.conditions.iter().flat_map(|condition| {
        condition.robots.iter().map(|robot| RobotRow {
            condition: condition.label.clone(),
            experiment: condition.experiment.name.clone(),
            replication: robot.replication,
            generation: robot.generation,
            individual: robot.individual,
            genes: robot.genes.clone(),
        })
    });
    rows.collect()
}

/// Every pair of conditions by both tests; of a pair the later condition, of which more is expected, comes first.
#[must_use]
pub fn pairs(study: &Study) -> Vec<PairRow> {
    let mut rows = Vec::new();
    for quantity in Quantity::ALL {
        let later = (0..study.conditions.len()).rev();
        let pairs = later.flat_map(|a| (0..a).rev().map(move |b| (a, b)));
        let tests: Vec<(&Condition, &Condition, MannWhitney)> = pairs
            .filter_map(|(a, b)| {
                let (a, b) = (&study.conditions[a], &study.conditions[b]);
                Some((a, b, mann_whitney(&quantity.of(a), &quantity.of(b))?))
            })
            .collect();
        let corrected = holm(&tests.iter().map(|(_, _, test)| test.p).collect::<Vec<_>>());
        rows.extend(tests.into_iter().zip(corrected).map(|((a, b, test), p_holm)| PairRow {
            test: quantity.name().to_owned(),
            a: a.label.clone(),
            b: b.label.clone(),
            u: test.u,
            p: test.p,
            p_holm,
            a12: test.a12,
        }));
    }
    rows
}

pub(super) fn aid(study: &Study) -> Vec<AidRow> {
    let mut rows = Vec::new();
    for condition in &study.conditions {
        for robot in &condition.robots {
            let Some(aided) = &robot.aided else { continue };
            let own = &robot.generalisation;
            let success = |outcomes: &[TrialOutcome]| -> Vec<f64> {
                outcomes.iter().map(|outcome| f64::from(u8::from(outcome.success))).collect()
            };
            let steps = |outcomes: &[TrialOutcome]| -> Vec<f64> {
                outcomes
                    .iter()
                    .filter(|outcome| outcome.success)
                    .map(|outcome| outcome.steps.into())
                    .collect()
            };
            let (own_steps, aided_steps) = (steps(own), steps(aided));
            rows.push(AidRow {
                condition: condition.label.clone(),
                replication: robot.replication,
                trials: own.len() as u32,
                own_successes: successes(own),
                aided_successes: successes(aided),
                p_successes: mann_whitney(&success(own), &success(aided)).map(|test| test.p),
                own_steps_to_goal: median(&own_steps),
                aided_steps_to_goal: median(&aided_steps),
                p_steps: mann_whitney(&own_steps, &aided_steps).map(|test| test.p),
            });
        }
    }
    rows
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::report::Robot;
    use selftalk_sim::Experiment;

    /// Outcomes of so many trials of which the first succeed, each a step later than the one before.
    pub(crate) fn outcomes(successes: u32, of: u32) -> Vec<TrialOutcome> {
        (0..of)
            .map(|trial| TrialOutcome { score: 0.5, success: trial < successes, steps: 50 + trial })
            .collect()
    }

    /// A condition with robots of so many successes in post-evaluation.
    pub(crate) fn condition(label: &str, post: &[u32]) -> Condition {
        let robot = |(replication, successes): (u32, &u32)| Robot {
            replication,
            generation: 10 + replication,
            individual: 0,
            genes: "00ff".to_owned(),
            post: outcomes(*successes, 40),
            generalisation: outcomes(4 * successes, 196),
            aided: (label == "LST").then(|| outcomes(3 * successes, 196)),
        };
        let curve = (0..5).flat_map(|generation| {
            (0..post.len() as u32).map(move |replication| CurveRow {
                condition: label.to_owned(),
                replication,
                generation,
                fitness: 0.1 * f64::from(generation),
                successes_of_8: generation,
                post_successes_of_40: 8 * generation,
            })
        });
        Condition {
            label: label.to_owned(),
            experiment: Experiment::default(),
            robots: (0..).zip(post).map(robot).collect(),
            curve: curve.collect(),
            digests: vec![(0, "ab".to_owned())],
            fingerprint: "cd".to_owned(),
        }
    }

    #[test]
    fn a_pair_is_compared_by_both_tests_the_better_expected_first() {
        let study =
            Study { conditions: vec![condition("C", &[10, 12, 14]), condition("LST", &[38, 39, 40])] };
        let rows = pairs(&study);
        assert_eq!(rows.iter().map(|row| row.test.as_str()).collect::<Vec<_>>(), ["post", "generalisation"]);
        for row in rows {
            assert_eq!((row.a.as_str(), row.b.as_str()), ("LST", "C"));
            assert_eq!((row.u, row.a12), (9.0, 1.0));
            assert!((row.p - 0.1).abs() < 1e-12 && (row.p_holm - 0.1).abs() < 1e-12);
        }
    }

    #[test]
    fn summary_and_aid_count_successes() {
        let study = Study { conditions: vec![condition("C", &[10]), condition("LST", &[40])] };
        let summary = summary(&study);
        let counts = |row: &SummaryRow| (row.post_successes_of_40, row.generalisation_successes_of_196);
        assert_eq!(summary.iter().map(counts).collect::<Vec<_>>(), [(10, 40), (40, 160)]);
        let aid = aid(&study);
        assert_eq!(aid.len(), 1, "only where there is a caretaker");
        assert_eq!((aid[0].own_successes, aid[0].aided_successes), (160, 120));
        assert_eq!((aid[0].own_steps_to_goal, aid[0].aided_steps_to_goal), (Some(129.5), Some(109.5)));
        assert!(aid[0].p_successes.unwrap() < 0.001 && aid[0].p_steps.unwrap() < 0.001);
    }
}
