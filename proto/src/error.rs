//! What can be wrong with a message.

use selftalk_sim::genotype::GenotypeError;
use thiserror::Error;

/// Why a message is refused.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum WireError {
    /// A part that every message of this kind has is not there.
    #[error("the message has no {0}")]
    Missing(&'static str),
    /// A unit's key has another length.
    #[error("a unit's key takes 16 bytes, not {0}")]
    Key(usize),
    /// A unit's genotype is not made of whole genes.
    #[error(transparent)]
    Genotype(#[from] GenotypeError),
    /// A unit has no trials, or more than can be counted.
    #[error("a unit cannot have {trials} trials from trial {first} on")]
    Trials {
        /// The first trial.
        first: u32,
        /// How many there are.
        trials: u32,
    },
    /// A worker has no slots or too many.
    #[error("a worker must have 1 to {limit} slots, not {0}", limit = crate::SLOT_LIMIT)]
    Slots(u32),
    /// A text is too long.
    #[error("{field} is longer than {limit} bytes")]
    TooLong {
        /// Which text.
        field: &'static str,
        /// Longest that is allowed, in bytes.
        limit: usize,
    },
}
