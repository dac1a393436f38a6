//! Counter-based randomness: every draw is a function of where it is used, so nothing about it needs saving.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// What a stream of random numbers is used for; part of the stream's key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum Purpose {
    /// The random genes of generation 0.
    Founder = 1,
    /// The bits that flip when a parent's copy is varied.
    Mutation = 2,
    /// Object and target positions of a trial.
    TrialDraw = 3,
    /// Target positions of a trial of generalisation.
    Generalisation = 4,
}

/// The place in an experiment at which random numbers are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StreamKey {
    /// The experiment's seed.
    pub seed: u64,
    /// Replication, counted from 0.
    pub replication: u32,
    /// Generation, counted from 0.
    pub generation: u32,
    /// What the numbers are for.
    pub purpose: Purpose,
    /// Individual or trial, counted from 0.
    pub index: u32,
}

impl StreamKey {
    /// The stream of this key: ChaCha8 with the key's fields, little-endian, as its 256-bit key.
    #[must_use]
    pub fn stream(self) -> ChaCha8Rng {
        let mut key = [0_u8; 32];
        key[0..8].copy_from_slice(&self.seed.to_le_bytes());
        key[8..12].copy_from_slice(&self.replication.to_le_bytes());
        key[12..16].copy_from_slice(&self.generation.to_le_bytes());
        key[16..20].copy_from_slice(&(self.purpose as u32).to_le_bytes());
        key[20..24].copy_from_slice(&self.index.to_le_bytes());
        ChaCha8Rng::from_seed(key)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::Rng;

    const KEY: StreamKey =
        StreamKey { seed: 1, replication: 2, generation: 3, purpose: Purpose::Mutation, index: 4 };

    #[test]
    fn every_field_of_the_key_changes_the_stream() {
        let first = KEY.stream().next_u64();
        let others = [
            StreamKey { seed: 9, ..KEY },
            StreamKey { replication: 9, ..KEY },
            StreamKey { generation: 9, ..KEY },
            StreamKey { purpose: Purpose::Founder, ..KEY },
            StreamKey { index: 9, ..KEY },
        ];
        assert_eq!(first, KEY.stream().next_u64());
        for other in others {
            assert_ne!(first, other.stream().next_u64(), "{other:?}");
        }
    }

    #[test]
    fn a_stream_keeps_its_values_across_releases() {
        assert_eq!(KEY.stream().next_u64(), GOLDEN);
    }

    const GOLDEN: u64 = 10_486_941_320_430_045_125;
}
