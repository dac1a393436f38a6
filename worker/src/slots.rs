//! The threads that simulate.

use std::any::Any;
use std::cell::RefCell;
use std::convert::Infallible;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use selftalk_proto::{Answer, UnitResult};
use selftalk_sim::Simulator;
use tokio::sync::mpsc::UnboundedSender;
use tokio::time::sleep;

use crate::queue::{Queue, Study, Task};
use crate::usage::Usage;

/// The threads. They end when this is dropped; [`Slots::stop`] also waits for them.
#[derive(Debug)]
pub(crate) struct Slots {
    queue: Arc<Queue>,
    threads: Vec<JoinHandle<()>>,
}

impl Slots {
    /// Starts `count` threads that send the units' results to `results`.
    pub(crate) fn start(count: u32, results: UnboundedSender<UnitResult>) -> std::io::Result<Self> {
        let mut slots = Self { queue: Arc::default(), threads: Vec::new() };
        for slot in 0..count {
            let (queue, results) = (Arc::clone(&slots.queue), results.clone());
            let thread = std::thread::Builder::new().name(format!("slot-{slot}"));
            slots.threads.push(thread.spawn(move || work(&queue, &results))?);
        }
        Ok(slots)
    }

    pub(crate) fn queue(&self) -> &Arc<Queue> {
        &self.queue
    }

    /// Ends the threads after the trials they have under way.
    pub(crate) async fn stop(mut self) {
        self.queue.stop();
        let threads = std::mem::take(&mut self.threads);
        let joined = tokio::task::spawn_blocking(move || threads.into_iter().try_for_each(JoinHandle::join));
        if !matches!(joined.await, Ok(Ok(()))) {
            tracing::error!("a slot has panicked");
        }
    }
}

impl Drop for Slots {
    fn drop(&mut self) {
        self.queue.stop();
    }
}

fn work(queue: &Queue, results: &UnboundedSender<UnitResult>) {
    let mut usage = Usage::default();
    let mut last = None;
    while let Some((study, simulator)) = queue.wait(last) {
        usage.measure(|| simulate(queue, study, &simulator, results, usize::MAX));
        last = Some(study);
    }
    usage.report();
}

/// What a slot does, in the caller's task: every `pace` as many trials as a unit has.
pub(crate) async fn work_in_task(
    queue: &Queue,
    results: &UnboundedSender<UnitResult>,
    pace: Duration,
) -> Infallible {
    let mut last = None;
    loop {
        sleep(pace).await;
        if let Some((study, simulator)) = queue.look(last) {
            simulate(queue, study, &simulator, results, simulator.trial_count() as usize);
            last = Some(study);
        }
    }
}

/// Runs trials of one experiment for as long as there are any, and no more than `most`.
fn simulate(
    queue: &Queue,
    study: Study,
    simulator: &Simulator,
    results: &UnboundedSender<UnitResult>,
    most: usize,
) {
    let answer = |task: &Arc<Task>, answer| {
        if queue.close(task) {
            // Nobody listens only when the worker ends.
            let _ = results.send(UnitResult { key: task.key, answer });
        }
    };
    let lanes: RefCell<Vec<Arc<Task>>> = RefCell::default();
    let mut left = most;
    let next = || {
        left = left.checked_sub(1)?;
        let job = queue.next(study)?;
        lanes.borrow_mut().push(Arc::clone(&job.tag.0));
        Some(job)
    };
    let done = |(task, trial): (Arc<Task>, u32), outcome| {
        let mut lanes = lanes.borrow_mut();
        if let Some(lane) = lanes.iter().position(|other| Arc::ptr_eq(other, &task)) {
            lanes.swap_remove(lane);
        }
        if let Some(outcomes) = task.note(trial, outcome) {
            answer(&task, Answer::Outcomes(outcomes));
        }
    };
    let reason = match catch_unwind(AssertUnwindSafe(|| simulator.run(next, done))) {
        Ok(Ok(())) => return,
        Ok(Err(error)) => error.to_string(),
        Err(panic) => format!("the simulator panicked: {}", panic_text(&*panic)),
    };
    // Any of them may be the cause. The master gives each out again, apart from the others.
    tracing::error!(reason, "trials were given up");
    for task in lanes.take() {
        answer(&task, Answer::Failed(reason.clone()));
    }
    queue.purge();
}

fn panic_text(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message")
}

#[cfg(test)]
mod tests {
    use super::*;
    use selftalk_proto::UnitKey;
    use selftalk_sim::{Draw, Experiment, Genotype};
    use tokio::sync::mpsc;

    fn task(number: u8, genes: usize, simulator: &Simulator) -> Arc<Task> {
        let draw = Draw { replication: 0, generation: 0 };
        let genotype = Arc::new(Genotype::new(vec![1_000 * u16::from(number); genes]));
        Task::new(UnitKey::from_bytes([number; 16]), genotype, draw, 0..simulator.trial_count())
    }

    #[tokio::test]
    async fn results_are_those_of_the_simulator_and_a_bad_unit_fails_alone() {
        let simulator = Simulator::new(&Experiment::default()).unwrap();
        let genes = simulator.gene_count();
        let (results, mut outbox) = mpsc::unbounded_channel();
        let slots = Slots::start(2, results).unwrap();
        let study = slots.queue().open(simulator.clone());
        let bad = task(0, 1, &simulator);
        slots.queue().push([(study, Arc::clone(&bad))]);
        let failed = outbox.recv().await.unwrap();
        assert!(failed.key == bad.key && matches!(failed.answer, Answer::Failed(_)), "{failed:?}");

        let good: Vec<_> = (1..6).map(|number| task(number, genes, &simulator)).collect();
        slots.queue().push(good.iter().map(|task| (study, Arc::clone(task))));
        let mut got = Vec::new();
        for _ in &good {
            got.push(outbox.recv().await.unwrap());
        }
        got.sort_by_key(|result| result.key);
        for (number, (result, task)) in (1_u16..).zip(got.into_iter().zip(&good)) {
            let genotype = Genotype::new(vec![1_000 * number; genes]);
            let draw = Draw { replication: 0, generation: 0 };
            let outcomes = simulator.evaluate(&genotype, draw, 0..simulator.trial_count()).unwrap();
            assert_eq!(result, UnitResult { key: task.key, answer: Answer::Outcomes(outcomes) });
        }
        assert_eq!(slots.queue().live(), []);
        slots.stop().await;
        assert!(outbox.recv().await.is_none());
    }
}
