//! Stored individuals, run again: in the trials they were selected by, in fresh ones, in another engine.
//!
//! All of it runs on the cores of this machine, and no result depends on how many there are.

mod batch;
mod battery;
mod champion;
mod course;
mod tally;
#[cfg(test)]
mod tests;
mod verify;
mod why;
mod words;

use selftalk_sim::SimError;
use thiserror::Error;

pub use batch::{Crew, Task, run};
pub use battery::{battery, cases};
pub use champion::{CANDIDATES, Candidate, Champion, VALIDATION_DRAWS, champion};
pub use course::Course;
pub use tally::{Tally, tallies};
pub use verify::{Mismatch, difference, examine};
pub use why::{Why, why};

/// Why individuals cannot be run again.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum RetestError {
    /// A genotype or trial does not fit the experiment.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// A thread that ran trials has panicked.
    #[error("the simulator panicked")]
    Panicked,
}
