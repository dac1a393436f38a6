//! The records of a history.
