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

#[cfg(test)]
mod tests {
    use crate::experiment::{Engine, Experiment};
    use crate::physics::EngineError;
    use crate::{Draw, Genotype, SimError, Simulator};

    #[test]
    fn outcomes_depend_on_genes_draw_trial_and_seed_and_are_better_with_more_ones() {
        let experiment = |seed| Experiment { engine: Engine::Null, seed, ..Experiment::default() };
        let simulator = Simulator::new(&experiment(1)).unwrap();
        let genotype = |gene: u16, last: u16| {
            let mut genes = vec![gene; simulator.gene_count()];
            *genes.last_mut().unwrap() = last;
            Genotype::new(genes)
        };
        let draw = |replication, generation| Draw { replication, generation };
        let evaluate = |genotype: &Genotype, draw| simulator.evaluate(genotype, draw, 0..16).unwrap();
        let (one, two) = (genotype(0x00ff, 0x00ff), genotype(0x00ff, 0xff00));
        let base = evaluate(&one, draw(0, 0));
        assert_eq!(base, evaluate(&one, draw(0, 0)));
        for other in [evaluate(&two, draw(0, 0)), evaluate(&one, draw(1, 0)), evaluate(&one, draw(0, 1))] {
            assert_ne!(base, other);
        }
        let other = Simulator::new(&experiment(2)).unwrap();
        assert_ne!(base, other.evaluate(&one, draw(0, 0), 0..16).unwrap());
        assert!(base.windows(2).all(|pair| pair[0] != pair[1]), "{base:?}");
        let sum = |gene| evaluate(&genotype(gene, gene), draw(0, 0)).iter().map(|o| o.score).sum::<f64>();
        assert!(sum(0x0001) < sum(0x00ff) && sum(0x00ff) < sum(0x7fff));
    }

    #[test]
    fn what_does_not_fit_is_refused_and_nothing_can_be_looked_at() {
        let experiment = Experiment { engine: Engine::Null, ..Experiment::default() };
        let simulator = Simulator::new(&experiment).unwrap();
        let draw = Draw { replication: 0, generation: 0 };
        let short = Genotype::new([0_u16; 3]);
        assert!(matches!(simulator.evaluate(&short, draw, 0..1), Err(SimError::Genotype(_))));
        let good = Genotype::new(vec![0; simulator.gene_count()]);
        assert!(matches!(simulator.evaluate(&good, draw, 15..17), Err(SimError::Trial { trial: 16, .. })));
        let case = crate::Case::Drawn { draw, trial: 0 };
        assert_eq!(simulator.trace(&good, case), Err(SimError::Engine(EngineError::Null)));
    }
}
