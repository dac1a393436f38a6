//! What a run came to, at its end.

use super::choose::command;
use super::{Global, history};
use crate::exit::Failure;
use crate::store::StoredExperiment;

/// Prints how the replications stand.
///
/// # Errors
/// Those of printing.
pub(super) fn print_summary(experiments: &[StoredExperiment], global: &Global) -> Result<(), Failure> {
    history::replications(experiments).print(global.format)
}

/// Says on stderr what can be asked next.
pub(super) fn next_steps(experiments: &[StoredExperiment], global: &Global) {
    let Some(stored) = experiments.first() else { return };
    let name = &stored.experiment.name;
    let steps = [
        ("how it learned", format!("history generations --experiment {name}")),
        ("how the best came to be", format!("history lineage --experiment {name}")),
        ("what every run of it agrees on", format!("digest {name}")),
    ];
    eprintln!("\nNext:");
    for (why, what) in steps {
        eprintln!("  {why:32}{}", command(global, &what));
    }
}
