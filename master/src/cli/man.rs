//! `selftalk man`: the manual pages, made from what `--help` says.

use std::fs;

use clap::CommandFactory;

use super::args::ManArgs;
use super::{Cli, output};
use crate::exit::{Exit, Failure};

/// Carries out the command.
///
/// # Errors
/// [`Failure`] with the exit code and the line to print.
pub fn run(args: &ManArgs) -> Result<(), Failure> {
    let Some(folder) = &args.out else {
        let mut text = Vec::new();
        let written = clap_mangen::Man::new(Cli::command()).render(&mut text);
        written.map_err(|error| Failure::new(Exit::Unexpected, error))?;
        return output::print_text(&text);
    };
    let written = fs::create_dir_all(folder).and_then(|()| clap_mangen::generate_to(Cli::command(), folder));
    written.map_err(|error| {
        Failure::new(Exit::Unexpected, format!("{}: cannot be written: {error}", folder.display()))
    })?;
    eprintln!(
        "{} has the pages; `man -l {}` shows the first",
        folder.display(),
        folder.join("selftalk.1").display()
    );
    Ok(())
}
