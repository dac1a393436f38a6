//! Whether two processes run the same simulator.

use rand::RngExt;
use sha2::{Digest, Sha256};

use crate::experiment::Experiment;
use crate::genotype::Genotype;
use crate::simulator::{SimError, Simulator};
use crate::stream::{Purpose, StreamKey};
use crate::trial::{Draw, TRIALS};

/// Identifies the simulator by what it does: the hash of the outcomes of random controllers in all trials of the
/// default experiment. Processes with equal fingerprints give equal bits for equal work, whatever machine or
/// compiler they come from. Takes some tens of milliseconds.
///
/// # Errors
/// [`SimError`] when a shipped file is damaged.
pub fn fingerprint() -> Result<String, SimError> {
    let experiment = Experiment::default();
    let simulator = Simulator::new(&experiment)?;
    let mut hash = Sha256::new();
    for index in 0..2 {
        let key = StreamKey { seed: 0, replication: 0, generation: 0, purpose: Purpose::Founder, index };
        let mut stream = key.stream();
        let genes: Vec<u16> = (0..simulator.gene_count()).map(|_| stream.random()).collect();
        let draw = Draw { replication: 0, generation: index };
        for outcome in simulator.evaluate(&Genotype::new(genes), draw, 0..TRIALS)? {
            hash.update(outcome.score.to_bits().to_le_bytes());
            hash.update([u8::from(outcome.success)]);
            hash.update(outcome.steps.to_le_bytes());
        }
    }
    Ok(hash.finalize().iter().take(16).map(|byte| format!("{byte:02x}")).collect())
}
