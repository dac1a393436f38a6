//! More generations than an experiment was planned for.

use super::{SqliteStore, StoreError, StoredExperiment};

impl SqliteStore {
    /// Plans so many generations for an experiment, more than before. Replications that have run all of those before are not
    /// finished any more; one that ended at its first optimum stays as it is.
    ///
    /// # Errors
    /// [`StoreError`] when the history cannot be written.
    pub async fn extend(&self, stored: &StoredExperiment, generations: u32) -> Result<(), StoreError> {
        let mut experiment = stored.experiment.clone();
        experiment.generations = generations;
        let mut state = self.begin().await?;
        let plan = sqlx::query("UPDATE experiment SET settings = ? WHERE id = ?");
        let plan = plan.bind(experiment.to_toml()).bind(stored.id.0).execute(&mut state.connection).await;
        plan.map_err(|error| self.fail(&error))?;
        let unfinished = sqlx::query(
            "UPDATE replication SET finished_at = NULL WHERE experiment_id = ? AND NOT (? AND EXISTS ( \
                SELECT 1 FROM generation WHERE replication_id = replication.id AND optimal_individuals > 0))",
        );
        let unfinished = unfinished.bind(stored.id.0).bind(experiment.evolution.stop_at_optimum);
        unfinished.execute(&mut state.connection).await.map_err(|error| self.fail(&error))?;
        self.commit(state).await
    }
}

#[cfg(test)]
mod tests {
    use crate::store::tests::{commit, experiment, next, run};
    use crate::store::{SqliteStore, Store};

    #[tokio::test]
    async fn all_but_those_that_ended_at_an_optimum_go_on() {
        let folder = tempfile::tempdir().unwrap();
        let store = SqliteStore::open_writer(&folder.path().join("a.db")).await.unwrap();
        let mut experiment = experiment("a");
        (experiment.generations, experiment.evolution.stop_at_optimum) = (4, true);
        run(&store, &experiment, 3).await;
        let [first, second] = &store.experiment("a").await.unwrap().unwrap().replications[..] else {
            panic!()
        };
        let mut optimal = next(&store, &experiment, first.id, 0).await;
        for evaluated in &mut optimal.evaluated {
            evaluated.outcomes.iter_mut().for_each(|outcome| outcome.success = true);
        }
        optimal.scored.iter_mut().for_each(|scored| scored.successes = 16);
        commit(&store, first.id, &optimal, true).await.unwrap();
        let last = next(&store, &experiment, second.id, 1).await;
        commit(&store, second.id, &last, true).await.unwrap();

        let before = store.experiment("a").await.unwrap().unwrap();
        assert!(before.replications.iter().all(|replication| replication.finished));
        store.extend(&before, 6).await.unwrap();
        let after = store.experiment("a").await.unwrap().unwrap();
        assert_eq!(after.experiment.generations, 6);
        let finished: Vec<bool> = after.replications.iter().map(|replication| replication.finished).collect();
        assert_eq!(finished, [true, false]);
        let mut expected = before.clone();
        expected.experiment.generations = 6;
        expected.replications[1].finished = false;
        assert_eq!(after, expected, "nothing else has changed");
    }
}
