//! `selftalk resume`.

use super::args::ResumeArgs;
use super::choose::{continuable, open_existing, unfinished};
use super::conduct::{Workers, conduct, watch_signals};
use super::summary::{next_steps, print_summary};
use super::{Global, dashboard, select};
use crate::exit::Failure;

/// Carries out the command.
///
/// # Errors
/// [`Failure`] with the exit code and the line to print.
pub async fn run(args: ResumeArgs, global: &Global) -> Result<(), Failure> {
    let signal = watch_signals()?;
    let dashboard = dashboard::of_run(&args.shown).await?;
    let store = open_existing(global).await?;
    let mut experiments = select::experiments(&store, args.experiment.as_deref()).await?;
    if !experiments.iter().any(unfinished) {
        print_summary(&experiments, global)?;
        eprintln!("there is nothing to resume: all of it is finished");
        return Ok(store.close().await?);
    }
    experiments.retain(unfinished);
    experiments.iter().try_for_each(continuable)?;
    let workers = Workers::Here(args.workers.unwrap_or_else(selftalk_worker::available_cores));
    let ended = conduct(store, experiments, workers, &signal, dashboard.as_ref(), None, global).await?;
    print_summary(&ended, global)?;
    next_steps(&ended, global);
    Ok(())
}
