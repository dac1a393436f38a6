//! `selftalk digest`.

use super::Global;
use super::args::DigestArgs;
use crate::exit::{Exit, Failure};

/// Carries out the command.
///
/// # Errors
/// [`Failure`] with the exit code and the line to print.
pub async fn run(_args: DigestArgs, _global: &Global) -> Result<(), Failure> {
    Err(Failure::new(Exit::Unexpected, "not there yet"))
}
