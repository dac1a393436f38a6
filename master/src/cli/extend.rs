//! `selftalk extend`: more generations than an experiment was planned for.

use super::args::ExtendArgs;
use super::choose::{of_this_simulator, open_existing, resume_command, unfinished};
use super::summary::print_summary;
use super::{Global, select};
use crate::exit::{Exit, Failure};

/// Carries out the command.
///
/// # Errors
/// [`Failure`] with the exit code and the line to print.
pub async fn run(args: ExtendArgs, global: &Global) -> Result<(), Failure> {
    let store = open_existing(global).await?;
    let name = args.experiment.as_str();
    for stored in &select::experiments(&store, Some(name)).await? {
        of_this_simulator(stored)?;
        let planned = stored.experiment.generations;
        if args.generations <= planned {
            let message = format!("--generations {}: `{name}` has {planned} already", args.generations);
            return Err(Failure::new(Exit::Usage, message));
        }
        store.extend(stored, args.generations).await?;
    }
    let extended = select::experiments(&store, Some(name)).await?;
    store.close().await?;
    print_summary(&extended, global)?;
    if extended.iter().any(unfinished) {
        eprintln!("`{}` goes on with it", resume_command(global, name));
    } else {
        eprintln!("all replications have ended at their first optimum");
    }
    Ok(())
}
