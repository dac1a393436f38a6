//! The wire between master and workers.
