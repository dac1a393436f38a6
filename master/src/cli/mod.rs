//! The command line: one file a command. Data goes to stdout, progress, logs and failures to stderr.

mod ancestors;
pub mod args;
pub mod backup;
pub mod battery;
mod behaviours;
mod choose;
pub mod compare;
pub mod completions;
mod conduct;
pub mod dashboard;
pub mod digest;
pub mod evaluate;
pub mod export;
pub mod extend;
pub mod history;
pub mod individuals;
pub mod keys;
pub mod man;
pub mod operate;
pub mod output;
mod overall;
mod picture;
mod progress;
pub mod reference;
pub mod replay;
pub mod report;
pub mod reproduce;
pub mod results;
pub mod resume;
pub mod run;
pub mod select;
pub mod serve;
pub mod show;
mod space;
mod summary;
#[cfg(test)]
mod tests;
pub mod transfer;
pub mod verify;
mod weights;
mod work;

pub use args::{Cli, Color, Command, Format, Global, LogFormat};

use crate::exit::Failure;

/// Carries out a command line.
///
/// # Errors
/// [`Failure`] with the exit code and the line to print.
pub async fn execute(cli: Cli) -> Result<(), Failure> {
    let Cli { global, command } = cli;
    match command {
        Command::Run(args) => run::run(args, &global).await,
        Command::Serve(args) => serve::run(args, &global).await,
        Command::Resume(args) => resume::run(args, &global).await,
        Command::Extend(args) => extend::run(args, &global).await,
        Command::Dashboard(args) => dashboard::run(args, &global).await,
        Command::History(args) => history::run(args, &global).await,
        Command::Show(args) => show::run(args, &global).await,
        Command::Replay(args) => replay::run(args, &global).await,
        Command::Evaluate(args) => evaluate::run(args, &global).await,
        Command::Generalise(args) => battery::generalise(args, &global).await,
        Command::Compare(args) => compare::run(args, &global).await,
        Command::Transfer(args) => transfer::run(args, &global).await,
        Command::Verify(args) => verify::run(args, &global).await,
        Command::Results(args) => results::run(args, &global).await,
        Command::Report(args) => report::run(args, &global).await,
        Command::Reproduce(args) => reproduce::run(args, &global).await,
        Command::Export(args) => export::run(args, &global).await,
        Command::Backup(args) => backup::run(args, &global).await,
        Command::Digest(args) => digest::run(args, &global).await,
        Command::Operate(args) => operate::run(args, &global).await,
        Command::Keys(args) => keys::run(&args),
        Command::Completions(args) => completions::run(&args),
        Command::Man(args) => man::run(&args),
    }
}
