//! The simulator of the study: the iCub's torso, left arm and hand, its neural controller, and the trials in which
//! a controller is judged.
//!
//! The crate is pure and deterministic: no input or output, no clock, no threads, no global state. Scores are a
//! function of experiment, genotype and draw alone, bit for bit, on every machine.
//!
//! ```
//! use selftalk_sim::{Draw, Experiment, Genotype, Simulator};
//!
//! let experiment = Experiment::from_toml("short.toml", "reach = { steps = 5 }", &[])?;
//! let simulator = Simulator::new(&experiment)?;
//! // All weights are 0, so every motor is in the middle of its range.
//! let genotype = Genotype::new(vec![1 << 15; simulator.gene_count()]);
//! // The first four trials ask for REACH.
//! let outcomes = simulator.evaluate(&genotype, Draw { replication: 0, generation: 0 }, 0..4)?;
//! assert!(outcomes.iter().all(|outcome| outcome.steps == 5 && (0.0..=1.0).contains(&outcome.score)));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod behaviours;
pub mod body;
pub mod caretaker;
pub mod controller;
pub mod experiment;
mod fingerprint;
pub mod genotype;
mod null;
pub mod physics;
pub mod robot;
pub mod scene;
mod score;
mod simulator;
mod situation;
pub mod stream;
mod trial;

pub use behaviours::Behaviour;
pub use experiment::{Experiment, ExperimentError};
pub use fingerprint::fingerprint;
pub use genotype::Genotype;
pub use simulator::{Job, SimError, Simulator, Trace};
pub use situation::{Case, Draw};
pub use trial::{Frame, SETTLING, TrialOutcome};
