//! Outcomes without trials, for tests and measurements of all that is around the simulator.

use std::sync::Arc;

use rand::RngExt;

use crate::genotype::Genotype;
use crate::situation::{Case, Draw};
use crate::stream::{Purpose, StreamKey};
use crate::trial::TrialOutcome;

/// Most control steps that a trial is said to have lasted.
const STEPS: u32 = 100;

/// Invents outcomes. They depend on all that a simulated one depends on, on every gene and every draw, so that whoever
/// mixes something up is found out; and on the share of ones among a genotype's bits, so that there is something to
/// evolve.
#[derive(Debug)]
pub(crate) struct Null {
    seed: u64,
    /// What is known of the last genotype: its trials follow each other.
    last: Option<(Arc<Genotype>, Digest)>,
}

#[derive(Debug, Clone, Copy)]
struct Digest {
    hash: u64,
    /// Share of ones among the bits.
    ones: f64,
}

impl Null {
    pub(crate) const fn new(seed: u64) -> Self {
        Self { seed, last: None }
    }

    pub(crate) fn outcome(&mut self, genotype: &Arc<Genotype>, case: Case) -> TrialOutcome {
        let Digest { hash, ones } = self.digest(genotype);
        let (replication, generation, purpose, index) = match case {
            Case::Drawn { draw: Draw { replication, generation }, trial } => {
                (replication, generation, Purpose::TrialDraw, trial)
            }
            Case::Grid { number } => (0, 0, Purpose::Generalisation, number),
        };
        let key = StreamKey { seed: self.seed ^ hash, replication, generation, purpose, index };
        let mut stream = key.stream();
        let luck: f64 = stream.random();
        TrialOutcome {
            score: 0.75 * ones + 0.25 * luck,
            success: luck < ones * ones,
            steps: stream.random_range(1..=STEPS),
        }
    }

    fn digest(&mut self, genotype: &Arc<Genotype>) -> Digest {
        if let Some((known, digest)) = &self.last
            && Arc::ptr_eq(known, genotype)
        {
            return *digest;
        }
        let genes = genotype.genes();
        let ones: u32 = genes.iter().map(|gene| gene.count_ones()).sum();
        // FNV-1a, a gene at a time.
        let hash = genes.iter().fold(0xcbf2_9ce4_8422_2325, |hash: u64, gene| {
            (hash ^ u64::from(*gene)).wrapping_mul(0x0000_0100_0000_01b3)
        });
        let bits = genes.len() as f64 * f64::from(u16::BITS);
        let digest = Digest { hash, ones: f64::from(ones) / bits.max(1.0) };
        self.last = Some((Arc::clone(genotype), digest));
        digest
    }
}
