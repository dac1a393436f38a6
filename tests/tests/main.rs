//! The tests of the whole system, a module a subject. They are one program: each of their own would be linked with
//! everything there is, which takes longer than most of them run, and 100 MB.

// Helpers of tests are test code as well, though the compiler cannot know it.
#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used)]

mod architecture;
mod backup;
mod book;
mod browser;
mod chaos;
mod compare;
mod contract;
mod dashboard;
mod deploy;
mod digest;
mod documents;
mod export;
mod extend;
mod files;
mod fuzz;
mod guide;
mod history;
mod hostile;
mod hosts;
mod individuals;
mod json;
mod kept_results;
mod keys;
mod operate;
mod oracle;
mod places;
mod refusals;
mod replay;
mod reproduce;
mod signals;
mod simulation;
mod slurm;
mod storage;
mod token;
