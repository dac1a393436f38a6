//! Runs batches of trials for a master.
