//! `selftalk run`.

use super::Global;
use super::args::RunArgs;
use super::choose::{continuable, find_or_create, read, resume_command, unfinished};
use super::conduct::{Workers, conduct, watch_signals};
use super::summary::{next_steps, print_summary};
use crate::exit::{Exit, Failure};
use crate::store::{SqliteStore, Store};

/// Carries out the command.
///
/// # Errors
/// [`Failure`] with the exit code and the line to print.
pub async fn run(args: RunArgs, global: &Global) -> Result<(), Failure> {
    let mut overrides = args.set;
    overrides.extend(args.seed.map(|seed| format!("seed={seed}")));
    let experiment = read(&args.experiment, &overrides)?;
    let signal = watch_signals()?;
    let store = SqliteStore::open_writer(&global.db).await?;
    let name = &experiment.name;
    let begun = store.experiment(name).await?.is_some();
    let stored = find_or_create(&store, &experiment).await?;
    if !unfinished(&stored) {
        print_summary(&[stored], global)?;
        eprintln!(
            "`{name}` is finished already and is not run again; `--set name=...` runs it under another name"
        );
        return Ok(store.close().await?);
    }
    continuable(&stored)?;
    if begun {
        let message = format!(
            "experiment `{name}` was interrupted; `{}` goes on with it",
            resume_command(global, name)
        );
        return Err(Failure::new(Exit::Exists, message));
    }
    let workers = Workers::Here(args.workers.unwrap_or_else(selftalk_worker::available_cores));
    let ended = conduct(store, vec![stored], workers, &signal, global).await?;
    print_summary(&ended, global)?;
    next_steps(&ended, global);
    Ok(())
}
