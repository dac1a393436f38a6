//! The master: holds the population, hands batches of evaluations to workers, and keeps every generation in SQLite.
//!
//! The evolution alone, without workers and database:
//!
//! ```
//! use selftalk::evolution::{draw, founders, ranking, reproduce, score};
//! use selftalk_sim::{Experiment, Simulator};
//!
//! let text = "engine = 'null'\nevolution = { population = 10, parents = 2, mutation = 0.01 }";
//! let experiment = Experiment::from_toml("small.toml", text, &[])?;
//! let simulator = Simulator::new(&experiment)?;
//! let mut population = founders(&experiment, simulator.gene_count(), 0);
//! for generation in 0..3 {
//!     let draw = draw(&experiment, 0, generation);
//!     let mut scored = Vec::new();
//!     for member in &population.members {
//!         let outcomes = simulator.evaluate(&member.genotype, draw, 0..simulator.trial_count())?;
//!         scored.push(score(&simulator, &outcomes));
//!     }
//!     population = reproduce(&experiment, &population, &ranking(&scored));
//! }
//! assert_eq!(population.generation, 3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod cli;
pub mod dashboard;
pub mod driver;
pub mod evolution;
pub mod exit;
pub mod export;
pub mod master;
pub mod picture;
pub mod replay;
pub mod report;
pub mod results;
pub mod retest;
pub mod scheduler;
pub mod service;
pub mod statistics;
pub mod store;
pub mod weights;
