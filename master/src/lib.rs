//! The master: holds the population, hands batches of evaluations to workers, and keeps every generation in SQLite.

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
