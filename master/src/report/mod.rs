//! The study's second phase as a folder: figures, tables, and a page that sets them beside the paper's (paper, section
//! III).

mod boxes;
mod draw;
mod files;
mod page;
mod rows;

use std::path::{Path, PathBuf};

use selftalk_sim::experiment::{Added, Speaks};
use selftalk_sim::{Experiment, TrialOutcome};
use thiserror::Error;

pub use rows::{AidRow, CurveRow, PairRow, Quantity, RobotRow, SummaryRow, pairs};

/// Why a report cannot be written.
#[derive(Debug, Error)]
pub enum ReportError {
    /// A file cannot be written.
    #[error("{}: {reason}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What went wrong.
        reason: String,
    },
}

/// What the conditions of the second phase came to.
#[derive(Debug, Clone, PartialEq)]
pub struct Study {
    /// In the order in which they are shown.
    pub conditions: Vec<Condition>,
}

/// A condition: an experiment of the second phase whose robots have been tested.
#[derive(Debug, Clone, PartialEq)]
pub struct Condition {
    /// C, LE, ST or LST, or the experiment's name if its settings are of none of them.
    pub label: String,
    /// Its experiment.
    pub experiment: Experiment,
    /// The best robot of each replication.
    pub robots: Vec<Robot>,
    /// What the best individuals came to, generation by generation.
    pub curve: Vec<CurveRow>,
    /// Checksums of the replications' histories, and what they were run with.
    pub digests: Vec<(u32, String)>,
    /// The simulator's fingerprint.
    pub fingerprint: String,
}

/// The best robot of a replication: the one with most successes in post-evaluation.
#[derive(Debug, Clone, PartialEq)]
pub struct Robot {
    /// Its replication.
    pub replication: u32,
    /// Its generation.
    pub generation: u32,
    /// Its number there.
    pub individual: u32,
    /// Its genes, four hexadecimal digits each.
    pub genes: String,
    /// Its trials of post-evaluation.
    pub post: Vec<TrialOutcome>,
    /// Its trials of generalisation.
    pub generalisation: Vec<TrialOutcome>,
    /// The same places with the caretaker's labels; none where there is no caretaker.
    pub aided: Option<Vec<TrialOutcome>>,
}

/// The condition of the paper that an experiment's settings are of.
#[must_use]
pub fn label(experiment: &Experiment) -> String {
    let caretaker = &experiment.caretaker;
    let anticipates = caretaker.anticipation_share > 0.0;
    match (experiment.controller.added, caretaker.speaks, anticipates) {
        (Added::Internal, Speaks::Never, _) => "C",
        (Added::Internal, Speaks::Even, _) => "LE",
        (Added::Speech, Speaks::Never, _) => "ST",
        (Added::Speech, Speaks::Even, true) => "LST",
        _ => &experiment.name,
    }
    .to_owned()
}

impl Study {
    /// Orders conditions as the paper does: C, LE, ST, LST, then others. Of several experiments of one condition all but
    /// the first go by their names.
    #[must_use]
    pub fn new(mut conditions: Vec<Condition>) -> Self {
        let order =
            |label: &str| ["C", "LE", "ST", "LST"].iter().position(|known| *known == label).unwrap_or(4);
        conditions.sort_by_key(|condition| order(&condition.label));
        for at in 1..conditions.len() {
            if conditions[..at].iter().any(|before| before.label == conditions[at].label) {
                let condition = &mut conditions[at];
                condition.label = condition.experiment.name.clone();
                for row in &mut condition.curve {
                    row.condition = condition.label.clone();
                }
            }
        }
        Self { conditions }
    }

    /// Writes the report's files into a folder, which is created if need be. Files of those names are replaced.
    ///
    /// # Errors
    /// [`ReportError`] names the file.
    pub fn write(&self, folder: &Path) -> Result<(), ReportError> {
        files::write(self, folder)
    }
}

/// Share of trials that succeeded, in percent.
fn percent(outcomes: &[TrialOutcome]) -> f64 {
    let successes = outcomes.iter().filter(|outcome| outcome.success).count();
    100.0 * successes as f64 / outcomes.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use selftalk_sim::experiment::PRESETS;

    #[test]
    fn the_presets_of_the_second_phase_are_the_paper_s_conditions() {
        let integrated = PRESETS.iter().filter(|preset| preset.name.starts_with("integrated"));
        let labels: Vec<String> = integrated.map(|preset| label(&preset.experiment(&[]).unwrap())).collect();
        assert_eq!(labels, ["C", "LE", "ST", "LST"]);
        let mut other = Experiment { name: "mine".to_owned(), ..Experiment::default() };
        other.controller.added = Added::Speech;
        other.caretaker.speaks = Speaks::Even;
        assert_eq!(label(&other), "mine");
    }

    #[test]
    fn conditions_are_in_the_paper_s_order_and_none_has_another_s_label() {
        let again = |name: &str| {
            let mut condition = rows::tests::condition("C", &[1]);
            condition.experiment.name = name.to_owned();
            condition
        };
        let study = Study::new(vec![rows::tests::condition("LST", &[1]), again("first"), again("second")]);
        let labels: Vec<&str> = study.conditions.iter().map(|condition| condition.label.as_str()).collect();
        assert_eq!(labels, ["C", "second", "LST"]);
        assert!(study.conditions[1].curve.iter().all(|row| row.condition == "second"));
    }
}
