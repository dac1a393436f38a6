//! `selftalk backup`: a copy of the database while it is written.

use std::path::Path;
use std::time::Duration;

use tokio::time::{MissedTickBehavior, interval};

use super::args::BackupArgs;
use super::conduct::watch_signals;
use super::output::Table;
use super::{Global, select};
use crate::exit::Failure;
use crate::store::{SqliteStore, Store};

/// Carries out the command.
///
/// # Errors
/// [`Failure`] with the exit code and the line to print.
pub async fn run(args: BackupArgs, global: &Global) -> Result<(), Failure> {
    let store = select::open(global).await?;
    let Some(minutes) = args.every else {
        return copy(&store, &args.to).await?.print(global.format);
    };
    let signal = watch_signals()?;
    let mut moments = interval(Duration::from_secs(60 * u64::from(minutes)));
    moments.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        tokio::select! {
            () = signal.token().cancelled_owned() => return Ok(()),
            _ = moments.tick() => {}
        }
        match copy(&store, &args.to).await {
            Ok(table) => table.print(global.format)?,
            // A disk that is full now may not be so later; the copy from before is still there.
            Err(failure) => tracing::error!("{failure}; trying again in {minutes} minutes"),
        }
    }
}

async fn copy(store: &SqliteStore, to: &Path) -> Result<Table, Failure> {
    let bytes = store.back_up(to).await?;
    // What is in the copy; the history may be further by now.
    let copy = SqliteStore::open_reader(to).await?;
    let experiments = copy.experiments().await?;
    let generations: u64 = experiments
        .iter()
        .flat_map(|stored| &stored.replications)
        .map(|replication| u64::from(replication.generations))
        .sum();
    copy.close().await?;
    let mut table = Table::new(["file", "experiments", "generations", "bytes"]);
    table.push([
        to.display().to_string().into(),
        (experiments.len() as u64).into(),
        generations.into(),
        bytes.into(),
    ]);
    Ok(table)
}
