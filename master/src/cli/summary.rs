//! What a run came to, at its end.

use super::Global;
use super::choose::command;
use crate::exit::Failure;
use crate::store::StoredExperiment;

pub(super) fn print_summary(experiments: &[StoredExperiment], _global: &Global) -> Result<(), Failure> {
    for stored in experiments {
        println!("{:?}", stored.replications);
    }
    Ok(())
}

/// Says on stderr what can be asked next.
pub(super) fn next_steps(experiments: &[StoredExperiment], global: &Global) {
    let Some(stored) = experiments.first() else { return };
    let name = &stored.experiment.name;
    eprintln!("\nTry next:");
    for (what, why) in [
        (format!("history generations --experiment {name}"), "how it learned"),
        (format!("history lineage --experiment {name} --best"), "how the best came to be"),
        (format!("digest {name}"), "a checksum that every run of this experiment shares"),
    ] {
        eprintln!("  {}    # {why}", command(global, &what));
    }
}
