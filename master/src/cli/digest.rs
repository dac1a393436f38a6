//! `selftalk digest`: a checksum a replication.

use super::args::DigestArgs;
use super::output::Table;
use super::{Global, select};
use crate::exit::Failure;
use crate::store::{HistoryDigest, SqliteStore, StoredReplication};

/// Carries out the command.
///
/// # Errors
/// [`Failure`] with the exit code and the line to print.
pub async fn run(args: DigestArgs, global: &Global) -> Result<(), Failure> {
    table(&select::open(global).await?, &args).await?.print(global.format)
}

pub(super) async fn table(store: &SqliteStore, args: &DigestArgs) -> Result<Table, Failure> {
    let mut table = Table::new(["experiment", "replication", "generations", "sha256"]);
    for stored in select::experiments(store, args.experiment.as_deref()).await? {
        for replication in &stored.replications {
            let name = stored.experiment.name.as_str();
            let (number, count) = (replication.number, replication.generations);
            table.push([
                name.into(),
                number.into(),
                count.into(),
                checksum(store, replication).await?.into(),
            ]);
        }
    }
    Ok(table)
}

/// The checksum of a replication's history.
pub(super) async fn checksum(
    store: &SqliteStore,
    replication: &StoredReplication,
) -> Result<String, Failure> {
    let mut digest = HistoryDigest::new();
    let mut generations = store.generations(replication);
    // A master may be adding generations: those that were there at the start are meant.
    for generation in 0..replication.generations {
        digest.update(&generations.read(generation).await?);
    }
    Ok(digest.finish())
}
