//! The history: what is stored and read back.

mod model;

use std::future::Future;

pub use model::*;
