//! The replications that run side by side, and what is taken back of them.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use tokio::task::{Id, JoinError, JoinSet};
use tokio_util::sync::CancellationToken;

use super::replication::{Replication, Subject};
use super::{DriverError, RunEnd};
use crate::scheduler::Place;
use crate::service::Finding;
use crate::store::Store;

/// How the task of a replication ended.
pub(super) type Ended = Result<(Id, Result<RunEnd, DriverError>), JoinError>;

/// The replications of a run, each a task while there is something to do for it.
pub(super) struct Field<S> {
    store: Arc<S>,
    subjects: Vec<Arc<Subject<S>>>,
    tasks: JoinSet<Result<RunEnd, DriverError>>,
    running: HashMap<Id, Task>,
    /// Generations from which replications are taken back once their tasks have ended.
    doubted: BTreeMap<usize, u32>,
    shutdown: CancellationToken,
    interrupted: bool,
}

struct Task {
    /// Place of the replication among the subjects.
    index: usize,
    stop: CancellationToken,
}

impl<S: Store> Field<S> {
    pub(super) fn new(store: Arc<S>, subjects: Vec<Arc<Subject<S>>>, shutdown: CancellationToken) -> Self {
        let (tasks, running, doubted) = (JoinSet::new(), HashMap::new(), BTreeMap::new());
        Self { store, subjects, tasks, running, doubted, shutdown, interrupted: false }
    }

    /// How the run has ended, once there are no tasks any more.
    pub(super) fn end(&self) -> RunEnd {
        if self.interrupted { RunEnd::Interrupted } else { RunEnd::Finished }
    }

    pub(super) fn start(&mut self, index: usize, replication: Replication<S>) {
        let stop = self.shutdown.child_token();
        let task = self.tasks.spawn(replication.run(stop.clone()));
        self.running.insert(task.id(), Task { index, stop });
    }

    /// The next task that ends; none if there are no tasks.
    pub(super) async fn next(&mut self) -> Option<Ended> {
        self.tasks.join_next_with_id().await
    }

    /// Takes note of a task's end, and starts the replication again if some of it was taken back.
    ///
    /// # Errors
    /// [`DriverError`] when the replication cannot go on. The other tasks have ended then.
    pub(super) async fn conclude(&mut self, ended: Ended) -> Result<(), DriverError> {
        let (id, result) = match ended {
            Ok(ended) => ended,
            Err(error) => (error.id(), Err(DriverError::Panicked(error.to_string()))),
        };
        let Some(Task { index, .. }) = self.running.remove(&id) else { return Ok(()) };
        let result = match (result, self.doubted.remove(&index)) {
            (Ok(_), Some(from)) => self.again(index, from).await,
            (Ok(end), None) => {
                self.interrupted |= end == RunEnd::Interrupted;
                Ok(())
            }
            (Err(error), _) => Err(error),
        };
        if result.is_err() {
            self.stop().await;
        }
        result
    }

    /// Does what follows from looking into answers.
    ///
    /// # Errors
    /// [`DriverError`] when the history cannot be written. The other tasks have ended then.
    pub(super) async fn follow(&mut self, finding: Finding) -> Result<(), DriverError> {
        let followed = match finding {
            Finding::Wrong(places) => return self.revoke(places).await,
            Finding::Right(workers) => self.store.workers_audited(&workers).await,
        };
        if followed.is_err() {
            self.stop().await;
        }
        Ok(followed?)
    }

    /// Takes generations back: at once where the replication has ended, and otherwise once its task has.
    ///
    /// # Errors
    /// [`DriverError`] when a replication cannot go on. The other tasks have ended then.
    async fn revoke(&mut self, places: Vec<Place>) -> Result<(), DriverError> {
        for Place { experiment, replication, generation } in places {
            let asked = |subject: &Arc<Subject<S>>| {
                (subject.study.number, subject.number) == (experiment, replication)
            };
            let Some(index) = self.subjects.iter().position(asked) else { continue };
            if let Some(task) = self.running.values().find(|task| task.index == index) {
                task.stop.cancel();
                let from = self.doubted.entry(index).or_insert(generation);
                *from = generation.min(*from);
            } else if let Err(error) = self.again(index, generation).await {
                self.stop().await;
                return Err(error);
            }
        }
        Ok(())
    }

    async fn again(&mut self, index: usize, from: u32) -> Result<(), DriverError> {
        let Some(subject) = self.subjects.get(index).map(Arc::clone) else { return Ok(()) };
        subject.store.take_back(subject.id, from).await?;
        let replication = Replication::prepare(Arc::clone(&subject)).await?;
        subject.place.note(replication.generation(), false, None);
        self.start(index, replication);
        Ok(())
    }

    /// Stops all tasks. What goes wrong with them now was caused by what went wrong first.
    async fn stop(&mut self) {
        self.running.values().for_each(|task| task.stop.cancel());
        while self.tasks.join_next().await.is_some() {}
    }
}
