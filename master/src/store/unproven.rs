//! Reading the latest answers of workers that nobody has looked into.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::path::Path;

use sqlx::{FromRow, SqliteConnection};

use super::generations::GenerationReader;
use super::{ExperimentId, GenerationRecord, ReplicationId, StoreError, Unproven, WorkerId};

/// What a worker has contributed to a replication.
#[derive(FromRow)]
struct Contribution {
    worker_id: i64,
    name: String,
    experiment_id: i64,
    replication_id: i64,
    number: u32,
    first: u32,
    last: u32,
}

/// The latest contributions of a worker to an experiment come last.
const CONTRIBUTIONS: &str = "\
    SELECT worker_id, worker.name, experiment_id, replication.id AS replication_id, replication.number, first, last \
    FROM (SELECT worker_id, replication_id, min(generation) AS first, max(generation) AS last \
          FROM evaluation WHERE worker_id IN (SELECT id FROM worker WHERE audited_at IS NULL) \
          GROUP BY worker_id, replication_id) AS contribution \
    JOIN worker ON worker.id = worker_id \
    JOIN replication ON replication.id = contribution.replication_id \
    JOIN generation ON generation.replication_id = replication.id AND generation.number = last \
    ORDER BY worker_id, experiment_id, committed_at, replication.number";

pub(super) async fn read(
    path: &Path,
    connection: &mut SqliteConnection,
) -> Result<Vec<Unproven>, StoreError> {
    let fail = |error| StoreError::from_sqlite(path, &error);
    let contributions: Vec<Contribution> =
        sqlx::query_as(CONTRIBUTIONS).fetch_all(&mut *connection).await.map_err(fail)?;
    // The last answers of many workers are in the same generations.
    let mut records: BTreeMap<(i64, u32), GenerationRecord> = BTreeMap::new();
    let mut unproven = Vec::new();
    let same =
        |a: &Contribution, b: &Contribution| (a.worker_id, a.experiment_id) == (b.worker_id, b.experiment_id);
    for contributions in contributions.chunk_by(same) {
        let Some(latest) = contributions.last() else { continue };
        let &Contribution { worker_id, ref name, experiment_id, replication_id, number, last, .. } = latest;
        let record = match records.entry((replication_id, last)) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(unknown) => {
                let mut reader = GenerationReader::new(path, ReplicationId(replication_id), number);
                unknown.insert(reader.record(connection, last).await?)
            }
        };
        let since = |of: &Contribution| (ReplicationId(of.replication_id), of.first);
        let since = contributions.iter().map(since).collect();
        let answer = record.latest_of(WorkerId(worker_id));
        unproven.extend(answer.map(|(genotype, outcomes)| Unproven {
            worker: WorkerId(worker_id),
            name: name.clone(),
            experiment: ExperimentId(experiment_id),
            replication: number,
            generation: last,
            genotype,
            outcomes,
            since,
        }));
    }
    Ok(unproven)
}
