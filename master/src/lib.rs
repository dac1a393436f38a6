//! The master: holds the population, hands batches of evaluations to workers, and keeps every generation in SQLite.

pub mod evolution;
pub mod scheduler;
pub mod store;
