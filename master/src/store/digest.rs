//! A checksum over what must not depend on how a run went.

use sha2::{Digest, Sha256};

use super::GenerationRecord;
use crate::evolution::{Member, Origin};

/// SHA-256 over the generations of a replication, from the first on.
///
/// The bytes that are hashed, all integers little-endian, `u32` unless said otherwise; `f64` as the `u64` of its bits:
///
/// - the text `selftalk history 1` and a zero byte;
/// - for every generation: its number, the number of individuals, then
///   - for every individual: origin as one byte (0 founder, 1 elite, 2 varied), parent (2^32 - 1 for founders), number
///     of flipped bits, the flipped bits, number of genes, the genes (`u16` each), fitness (`f64`), successes;
///   - the individuals' numbers, the best first;
///   - the number of distinct genotypes, and for each: the first individual carrying it, the number of trials, and for
///     each trial score (`f64`; any that is not a number as `7ff8000000000000`), success (one byte), steps.
///
/// Names, settings, times, workers and reasons of failures do not enter.
#[derive(Debug, Clone)]
pub struct HistoryDigest {
    hash: Sha256,
}

impl Default for HistoryDigest {
    fn default() -> Self {
        Self::new()
    }
}

impl HistoryDigest {
    /// The digest of no generations.
    #[must_use]
    pub fn new() -> Self {
        Self { hash: Sha256::new().chain_update(b"selftalk history 1\0") }
    }

    /// Adds the next generation.
    pub fn update(&mut self, record: &GenerationRecord) {
        let GenerationRecord { population, evaluated, scored, ranking } = record;
        let mut bytes = Vec::with_capacity(256 * 1024);
        integer(&mut bytes, population.generation);
        length(&mut bytes, population.members.len());
        for (member, scored) in population.members.iter().zip(scored) {
            origin(&mut bytes, member);
            length(&mut bytes, member.genotype.genes().len());
            bytes.extend(member.genotype.genes().iter().flat_map(|gene| gene.to_le_bytes()));
            real(&mut bytes, scored.fitness);
            integer(&mut bytes, scored.successes);
        }
        ranking.iter().for_each(|member| integer(&mut bytes, *member));
        length(&mut bytes, evaluated.len());
        for evaluated in evaluated {
            integer(&mut bytes, evaluated.member);
            length(&mut bytes, evaluated.outcomes.len());
            for outcome in &evaluated.outcomes {
                real(&mut bytes, outcome.score);
                bytes.push(outcome.success.into());
                integer(&mut bytes, outcome.steps);
            }
        }
        self.hash.update(&bytes);
    }

    /// The digest in hexadecimal.
    #[must_use]
    pub fn finish(self) -> String {
        self.hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

fn origin(bytes: &mut Vec<u8>, member: &Member) {
    bytes.push(match member.origin {
        Origin::Founder => 0,
        Origin::Elite { .. } => 1,
        Origin::Varied { .. } => 2,
    });
    integer(bytes, member.origin.parent().unwrap_or(u32::MAX));
    length(bytes, member.origin.flipped().len());
    member.origin.flipped().iter().for_each(|bit| integer(bytes, *bit));
}

fn length(bytes: &mut Vec<u8>, length: usize) {
    integer(bytes, length as u32);
}

fn integer(bytes: &mut Vec<u8>, value: u32) {
    bytes.extend(value.to_le_bytes());
}

fn real(bytes: &mut Vec<u8>, value: f64) {
    bytes.extend(kept_bits(value).to_le_bytes());
}

/// The bits of a number as far as a history keeps them: SQLite knows neither the kinds of NaN and infinity nor the sign
/// of zero.
#[must_use]
pub fn kept_bits(value: f64) -> u64 {
    if !value.is_finite() {
        0x7ff8_0000_0000_0000
    } else if value == 0.0 {
        0
    } else {
        value.to_bits()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evolution::{founders, reproduce};
    use crate::store::WorkerId;
    use crate::store::tests::{GENES, evaluate, experiment};

    fn records() -> Vec<GenerationRecord> {
        let experiment = experiment("a");
        let first = evaluate(founders(&experiment, GENES, 0), None);
        let second = evaluate(reproduce(&experiment, &first.population, &first.ranking), None);
        vec![first, second]
    }

    fn digest(records: &[GenerationRecord]) -> String {
        let mut digest = HistoryDigest::new();
        records.iter().for_each(|record| digest.update(record));
        digest.finish()
    }

    #[test]
    fn everything_that_evolution_did_enters() {
        let original = digest(&records());
        let changes: [fn(&mut GenerationRecord); 10] = [
            |r| r.population.generation += 1,
            |r| r.population.members[3].origin = Origin::Founder,
            |r| r.population.members[1].origin = Origin::Varied { parent: 0, flipped: vec![1] },
            |r| r.population.members.swap(0, 5),
            |r| r.scored[7].fitness += 1e-16,
            |r| r.scored[7].successes += 1,
            |r| r.ranking.swap(50, 51),
            |r| r.evaluated[2].outcomes[15].score += 1e-16,
            |r| r.evaluated[2].outcomes[15].success ^= true,
            |r| r.evaluated[2].outcomes[15].steps += 1,
        ];
        for (number, change) in changes.iter().enumerate() {
            let mut changed = records();
            change(&mut changed[1]);
            assert_ne!(digest(&changed), original, "change {number}");
        }
        assert_ne!(digest(&records()[..1]), original);
    }

    #[test]
    fn how_the_run_went_does_not_enter() {
        let mut other = records();
        other[0].evaluated[0].worker = Some(WorkerId(9));
        other[1].evaluated[1].failure = Some("lost".to_owned());
        assert_eq!(digest(&other), digest(&records()));
    }

    #[test]
    fn the_layout_stays() {
        assert_eq!(digest(&records()), GOLDEN);
    }

    const GOLDEN: &str = "e055870144a4e259e8819b002700a6da063a36059afef892db3c1bba019c78bc";
}
