//! Whether two processes run the same simulator.

use std::ops::Range;

use rand::RngExt;
use sha2::{Digest, Sha256};

use crate::experiment::{Added, Engine, Experiment, Speaks, Task};
use crate::genotype::Genotype;
use crate::simulator::{SimError, Simulator};
use crate::situation::{self, Draw};
use crate::stream::{Purpose, StreamKey};

/// Identifies the simulator by what it does: the hash of the outcomes of random controllers in all trials of the
/// elementary behaviours, in short ones of MOVE-TO-TARGET with all that the second phase adds, and in the first steps
/// of some trials in the rapier engine. Processes with equal fingerprints give equal bits for equal work, whatever
/// machine or compiler they come from. Takes some tens of milliseconds.
///
/// # Errors
/// [`SimError`] when a shipped file is damaged.
pub fn fingerprint() -> Result<String, SimError> {
    let mut hash = Sha256::new();
    let experiment = elementary();
    for index in 0..2 {
        add_outcomes(&mut hash, &experiment, index, 0..situation::trials(experiment.task))?;
    }
    let experiment = integrated();
    for index in 0..2 {
        add_outcomes(&mut hash, &experiment, index, 0..situation::trials(experiment.task))?;
    }
    // The hand around the object on the table, and with it in the air: all that the slow engine computes.
    let experiment = brief(Engine::Rapier);
    for trial in [8, 12] {
        add_outcomes(&mut hash, &experiment, 0, trial..trial + 1)?;
    }
    Ok(hash.finalize().iter().take(16).map(|byte| format!("{byte:02x}")).collect())
}

/// The default experiment, with the defaults of old: another default makes no other simulator.
fn elementary() -> Experiment {
    let mut experiment = Experiment::default();
    experiment.controller.position_scale = 0.1;
    experiment.controller.position_limit = 2.5;
    experiment
}

/// Short trials of the second phase's controllers that speak, with the caretaker in every other trial.
fn integrated() -> Experiment {
    let mut experiment = Experiment { task: Task::MoveToTarget, ..elementary() };
    experiment.controller.added = Added::Speech;
    experiment.caretaker.speaks = Speaks::Even;
    experiment.caretaker.anticipation_share = 0.5;
    experiment.move_to_target.steps = 20;
    experiment
}

/// The elementary behaviours in another engine, with few and large steps.
fn brief(engine: Engine) -> Experiment {
    let mut experiment = Experiment { engine, ..elementary() };
    experiment.physics.substeps = 4;
    experiment.grasp.steps = 3;
    experiment.transport.steps = 3;
    experiment
}

/// Adds the outcomes of trials of a random controller.
fn add_outcomes(
    hash: &mut Sha256,
    experiment: &Experiment,
    index: u32,
    trials: Range<u32>,
) -> Result<(), SimError> {
    let simulator = Simulator::new(experiment)?;
    let key = StreamKey { seed: 0, replication: 0, generation: 0, purpose: Purpose::Founder, index };
    let mut stream = key.stream();
    let genes: Vec<u16> = (0..simulator.gene_count()).map(|_| stream.random()).collect();
    let draw = Draw { replication: 0, generation: index };
    for outcome in simulator.evaluate(&Genotype::new(genes), draw, trials)? {
        hash.update(outcome.score.to_bits().to_le_bytes());
        hash.update([u8::from(outcome.success)]);
        hash.update(outcome.steps.to_le_bytes());
    }
    Ok(())
}
