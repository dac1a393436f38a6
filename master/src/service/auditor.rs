//! The thread that evaluates answers of workers again.

use std::collections::HashMap;
use std::sync::mpsc as blocking;

use selftalk_sim::{Draw, Experiment, Genotype, Simulator, TrialOutcome};
use tokio::sync::mpsc::WeakSender;

use super::handle::Command;
use crate::scheduler::{Claim, Event};
use crate::store::kept_bits;

/// An answer to be looked into, and the experiment's file where it is the first of that experiment.
#[derive(Debug)]
pub(super) struct Audit {
    pub(super) claim: Claim,
    pub(super) toml: Option<String>,
}

/// Starts the thread. It ends when the returned sender is dropped, and does not keep the hub alive.
pub(super) fn start(hub: WeakSender<Command>) -> blocking::Sender<Audit> {
    let (audits, inbox) = blocking::channel::<Audit>();
    let work = move || {
        let mut simulators = HashMap::new();
        for Audit { claim, toml } in inbox {
            let experiment = claim.work.experiment;
            if let Some(toml) = toml {
                simulators.insert(experiment, simulator(&toml));
            }
            let Claim { work, outcomes, .. } = &claim;
            // What this master cannot evaluate is not held against a worker.
            let right = simulators
                .get(&experiment)
                .and_then(Option::as_ref)
                .is_none_or(|simulator| is_right(simulator, work.draw, &work.genotype, outcomes));
            let event = Event::Audited { instance: claim.instance, serial: claim.serial, right };
            let Some(hub) = hub.upgrade() else { return };
            if hub.blocking_send(Command::Events(vec![event])).is_err() {
                return;
            }
        }
    };
    if let Err(error) = std::thread::Builder::new().name("audit".to_owned()).spawn(work) {
        tracing::warn!(%error, "no thread for audits: the workers' answers are not looked into");
    }
    audits
}

fn simulator(toml: &str) -> Option<Simulator> {
    Simulator::new(&Experiment::from_toml("experiment", toml, &[]).ok()?).ok()
}

/// Whether the outcomes of a genotype's trials are what the simulator makes of them, as the history would keep them. What it
/// cannot evaluate is not held against who did.
#[must_use]
pub fn is_right(simulator: &Simulator, draw: Draw, genotype: &Genotype, outcomes: &[TrialOutcome]) -> bool {
    let trials = 0..simulator.trial_count();
    simulator.evaluate(genotype, draw, trials).ok().is_none_or(|expected| {
        expected.len() == outcomes.len()
            && expected.iter().zip(outcomes).all(|(expected, answered)| equal(expected, answered))
    })
}

/// Whether the history would keep the same of both.
fn equal(a: &TrialOutcome, b: &TrialOutcome) -> bool {
    (kept_bits(a.score), a.success, a.steps) == (kept_bits(b.score), b.success, b.steps)
}
