//! The unit of work: one genotype and a range of its trials.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use selftalk_sim::{Draw, Genotype};
use sha2::{Digest, Sha256};

use crate::{WireError, v1};

/// Identifies a unit by its content: the experiment, the draw, the genotype and the trials. A master that was
/// restarted asks for the same work under the same keys, so that results from before the restart still count.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct UnitKey([u8; 16]);

/// The keys of units that differ in their genotype alone.
#[derive(Debug, Clone)]
pub struct UnitKeys {
    /// Has taken in all the rest.
    hash: Sha256,
}

impl UnitKeys {
    /// Those of these trials in this draw; `experiment` is the complete experiment file.
    #[must_use]
    pub fn new(experiment: &str, draw: Draw, trials: &Range<u32>) -> Self {
        let mut hash = Sha256::new();
        hash.update((experiment.len() as u64).to_le_bytes());
        hash.update(experiment);
        for number in [draw.replication, draw.generation, trials.start, trials.end] {
            hash.update(number.to_le_bytes());
        }
        Self { hash }
    }

    /// The key of a genotype's unit.
    #[must_use]
    pub fn of(&self, genotype: &Genotype) -> UnitKey {
        let hash = self.hash.clone().chain_update(genotype.to_bytes());
        let mut key = [0; 16];
        key.copy_from_slice(&hash.finalize()[..16]);
        UnitKey(key)
    }
}

impl UnitKey {
    /// A key of the given bytes.
    #[must_use]
    pub const fn from_bytes(bytes: [u8; 16]) -> Self {
        Self(bytes)
    }

    /// Its first bytes as a number, as good as a random one.
    #[must_use]
    pub const fn leading(self) -> u64 {
        let [a, b, c, d, e, f, g, h, ..] = self.0;
        u64::from_le_bytes([a, b, c, d, e, f, g, h])
    }

    pub(crate) fn to_wire(self) -> Vec<u8> {
        self.0.to_vec()
    }

    pub(crate) fn from_wire(bytes: &[u8]) -> Result<Self, WireError> {
        Ok(Self(bytes.try_into().map_err(|_| WireError::Key(bytes.len()))?))
    }
}

impl fmt::Debug for UnitKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl fmt::Display for UnitKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0[..6].iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

/// A unit as it is given to a worker.
#[derive(Debug, Clone, PartialEq)]
pub struct Unit {
    /// Identifies the unit.
    pub key: UnitKey,
    /// The experiment, by the number under which it was sent.
    pub experiment: u32,
    /// Object and target positions.
    pub draw: Draw,
    /// The genotype to be evaluated.
    pub genotype: Arc<Genotype>,
    /// The trials, never empty.
    pub trials: Range<u32>,
    /// How many times the unit has been given out, this time included.
    pub attempt: u32,
}

impl From<&Unit> for v1::Unit {
    fn from(unit: &Unit) -> Self {
        Self {
            key: unit.key.to_wire(),
            experiment: unit.experiment,
            replication: unit.draw.replication,
            draw_generation: unit.draw.generation,
            genotype: unit.genotype.to_bytes(),
            first_trial: unit.trials.start,
            trials: unit.trials.end.saturating_sub(unit.trials.start),
            attempt: unit.attempt,
        }
    }
}

impl TryFrom<v1::Unit> for Unit {
    type Error = WireError;

    fn try_from(unit: v1::Unit) -> Result<Self, WireError> {
        let v1::Unit { first_trial: first, trials, .. } = unit;
        let end =
            first.checked_add(trials).filter(|_| trials > 0).ok_or(WireError::Trials { first, trials })?;
        Ok(Self {
            key: UnitKey::from_wire(&unit.key)?,
            experiment: unit.experiment,
            draw: Draw { replication: unit.replication, generation: unit.draw_generation },
            genotype: Arc::new(Genotype::from_bytes(&unit.genotype, unit.genotype.len() / 2)?),
            trials: first..end,
            attempt: unit.attempt,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(experiment: &str, replication: u32, generation: u32, gene: u16, trials: Range<u32>) -> UnitKey {
        UnitKeys::new(experiment, Draw { replication, generation }, &trials).of(&Genotype::new([gene]))
    }

    #[test]
    fn whatever_changes_the_work_changes_the_key() {
        let base = key("a", 1, 2, 3, 0..16);
        assert_eq!(base, key("a", 1, 2, 3, 0..16));
        for other in [
            key("b", 1, 2, 3, 0..16),
            key("a", 9, 2, 3, 0..16),
            key("a", 1, 9, 3, 0..16),
            key("a", 1, 2, 9, 0..16),
            key("a", 1, 2, 3, 1..16),
            key("a", 1, 2, 3, 0..15),
        ] {
            assert_ne!(base, other);
        }
    }

    #[test]
    fn malformed_units_are_refused() {
        let good = v1::Unit { key: vec![1; 16], genotype: vec![0; 4], trials: 16, ..Default::default() };
        assert!(Unit::try_from(good.clone()).is_ok());
        let refused = |change: fn(&mut v1::Unit)| {
            let mut unit = good.clone();
            change(&mut unit);
            Unit::try_from(unit).unwrap_err()
        };
        assert_eq!(refused(|unit| unit.key.truncate(15)), WireError::Key(15));
        assert_eq!(refused(|unit| unit.trials = 0), WireError::Trials { first: 0, trials: 0 });
        assert_eq!(
            refused(|unit| unit.first_trial = u32::MAX),
            WireError::Trials { first: u32::MAX, trials: 16 }
        );
        assert!(matches!(refused(|unit| unit.genotype.truncate(3)), WireError::Genotype(_)));
    }
}
