//! The simulator of the study: the iCub's torso, left arm and hand, its neural controller, and the trials in which
//! a controller is judged.
//!
//! The crate is pure and deterministic: no input or output, no clock, no threads, no global state. Scores are a
//! function of experiment, genotype and draw alone, bit for bit, on every machine.

pub mod experiment;
pub mod genotype;
pub mod simulator;
pub mod stream;

pub use experiment::{Experiment, ExperimentError};
pub use genotype::Genotype;
pub use simulator::{Behaviour, Draw, Job, SimError, Simulator, TrialOutcome};
