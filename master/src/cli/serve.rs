//! `selftalk serve`.

use super::Global;
use super::ancestors::adopt;
use super::args::ServeArgs;
use super::choose::{continuable, find_or_create, open_existing, read, unfinished};
use super::conduct::{Workers, conduct, listen, watch_signals};
use super::summary::{next_steps, print_summary};
use crate::exit::{Exit, Failure};
use crate::store::{SqliteStore, Store, StoredExperiment};

/// Carries out the command.
///
/// # Errors
/// [`Failure`] with the exit code and the line to print.
pub async fn run(args: ServeArgs, global: &Global) -> Result<(), Failure> {
    let mut asked = args.experiments.iter().map(|named| read(named, &[])).collect::<Result<Vec<_>, _>>()?;
    for experiment in &mut asked {
        adopt(experiment, args.ancestors.as_deref(), global).await?;
    }
    let signal = watch_signals()?;
    // A taken port is found out before anything is written.
    let listener = listen(args.listen).await?;
    let address = listener.local_addr().map_err(|error| Failure::new(Exit::Network, error))?;
    let (store, experiments) = if asked.is_empty() {
        let store = open_existing(global).await?;
        let experiments = store.experiments().await?;
        (store, experiments)
    } else {
        let store = SqliteStore::open_writer(&global.db).await?;
        let mut experiments: Vec<StoredExperiment> = Vec::new();
        for experiment in &asked {
            let stored = find_or_create(&store, experiment).await?;
            if experiments.iter().all(|other| other.id != stored.id) {
                experiments.push(stored);
            }
        }
        (store, experiments)
    };
    let (running, finished): (Vec<_>, Vec<_>) = experiments.into_iter().partition(unfinished);
    if running.is_empty() {
        print_summary(&finished, global)?;
        eprintln!("there is nothing to do: all of it is finished");
        return Ok(store.close().await?);
    }
    running.iter().try_for_each(continuable)?;
    eprintln!("listening on {address}; workers join with `selftalk-worker --master http://{address}`");
    let ended = conduct(store, running, Workers::Remote(listener), &signal, None, global).await?;
    print_summary(&ended, global)?;
    next_steps(&ended, global);
    Ok(())
}
