//! The trials that a worker's slots share.

use std::collections::{BTreeMap, VecDeque};
use std::ops::Range;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use selftalk_proto::UnitKey;
use selftalk_sim::{Case, Draw, Genotype, Job, Simulator, TrialOutcome};

/// An experiment's place in the queue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Study(usize);

/// A unit under way.
#[derive(Debug)]
pub(crate) struct Task {
    pub(crate) key: UnitKey,
    genotype: Arc<Genotype>,
    draw: Draw,
    trials: Range<u32>,
    progress: Mutex<Progress>,
}

#[derive(Debug)]
struct Progress {
    outcomes: Vec<Option<TrialOutcome>>,
    left: usize,
}

impl Task {
    pub(crate) fn new(key: UnitKey, genotype: Arc<Genotype>, draw: Draw, trials: Range<u32>) -> Arc<Self> {
        let count = trials.len();
        let progress = Mutex::new(Progress { outcomes: vec![None; count], left: count });
        Arc::new(Self { key, genotype, draw, trials, progress })
    }

    /// Notes a trial's outcome; returns all outcomes with the last one.
    pub(crate) fn note(&self, trial: u32, outcome: TrialOutcome) -> Option<Vec<TrialOutcome>> {
        let mut progress = lock(&self.progress);
        let index = trial.checked_sub(self.trials.start)? as usize;
        if progress.outcomes.get_mut(index)?.replace(outcome).is_none() {
            progress.left -= 1;
        }
        (progress.left == 0).then(|| progress.outcomes.drain(..).flatten().collect())
    }
}

/// The line of an experiment.
#[derive(Debug)]
struct Line {
    simulator: Simulator,
    /// Units with trials to be handed out, and the next trial of each.
    waiting: VecDeque<(Arc<Task>, u32)>,
}

#[derive(Debug, Default)]
struct State {
    lines: Vec<Line>,
    /// Units that have not been answered: waiting or under way.
    live: BTreeMap<UnitKey, Arc<Task>>,
    stopped: bool,
}

/// The queue: a line of units for each experiment, handed out trial by trial.
#[derive(Debug, Default)]
pub(crate) struct Queue {
    state: Mutex<State>,
    filled: Condvar,
}

/// A slot that panics must not take the others along; nothing in here is left half-done by a panic.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Queue {
    /// Opens a line for an experiment.
    pub(crate) fn open(&self, simulator: Simulator) -> Study {
        let mut state = lock(&self.state);
        state.lines.push(Line { simulator, waiting: VecDeque::new() });
        Study(state.lines.len() - 1)
    }

    /// Puts units at the ends of their experiments' lines, but for those that are in the worker's hands already.
    pub(crate) fn push(&self, tasks: impl IntoIterator<Item = (Study, Arc<Task>)>) {
        let mut state = lock(&self.state);
        for (study, task) in tasks {
            if state.live.contains_key(&task.key) {
                continue;
            }
            state.live.insert(task.key, Arc::clone(&task));
            let first = task.trials.start;
            state.lines[study.0].waiting.push_back((task, first));
        }
        drop(state);
        self.filled.notify_all();
    }

    /// Whether there are units that have not been answered.
    pub(crate) fn is_busy(&self) -> bool {
        !lock(&self.state).live.is_empty()
    }

    /// Waits until there is something to do and says for which experiment: the next one after `last` in turn.
    /// None when the worker stops.
    pub(crate) fn wait(&self, last: Option<Study>) -> Option<(Study, Simulator)> {
        let mut state = lock(&self.state);
        loop {
            if state.stopped {
                return None;
            }
            if let Some(found) = state.turn(last) {
                return Some(found);
            }
            state = self.filled.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// The same without waiting: none as well when there is nothing to do.
    pub(crate) fn look(&self, last: Option<Study>) -> Option<(Study, Simulator)> {
        let state = lock(&self.state);
        if state.stopped { None } else { state.turn(last) }
    }

    /// The next trial of an experiment, with its unit and its number, if there is one at the moment.
    pub(crate) fn next(&self, study: Study) -> Option<Job<(Arc<Task>, u32)>> {
        let mut state = lock(&self.state);
        if state.stopped {
            return None;
        }
        let waiting = &mut state.lines[study.0].waiting;
        let (task, trial) = waiting.front_mut()?;
        let job = Job {
            genotype: Arc::clone(&task.genotype),
            case: Case::Drawn { draw: task.draw, trial: *trial },
            tag: (Arc::clone(task), *trial),
        };
        *trial += 1;
        if *trial >= task.trials.end {
            waiting.pop_front();
        }
        Some(job)
    }

    /// Takes a unit off the worker's hands; false if it was not in them, so that its answer is not wanted any more.
    pub(crate) fn close(&self, task: &Arc<Task>) -> bool {
        let mut state = lock(&self.state);
        if !state.live.get(&task.key).is_some_and(|live| Arc::ptr_eq(live, task)) {
            return false;
        }
        state.live.remove(&task.key);
        true
    }

    /// Drops units; what is under way in a lane runs to its end and is dropped then.
    pub(crate) fn cancel(&self, keys: &[UnitKey]) {
        let mut state = lock(&self.state);
        for key in keys {
            state.live.remove(key);
        }
        state.retain_live();
    }

    /// Drops what is left of units that have been closed.
    pub(crate) fn purge(&self) {
        lock(&self.state).retain_live();
    }

    /// Units that have not been answered.
    pub(crate) fn live(&self) -> Vec<UnitKey> {
        lock(&self.state).live.keys().copied().collect()
    }

    /// Lets every slot end after the trials under way.
    pub(crate) fn stop(&self) {
        lock(&self.state).stopped = true;
        self.filled.notify_all();
    }
}

impl State {
    /// The next experiment after `last` in turn for which there is something to do.
    fn turn(&self, last: Option<Study>) -> Option<(Study, Simulator)> {
        let count = self.lines.len();
        let first = last.map_or(0, |study| study.0 + 1);
        let mut turns = (first..first + count).map(|study| study % count);
        let study = turns.find(|study| !self.lines[*study].waiting.is_empty())?;
        Some((Study(study), self.lines[study].simulator.clone()))
    }

    fn retain_live(&mut self) {
        let Self { lines, live, .. } = self;
        for line in lines {
            line.waiting.retain(|(task, _)| live.get(&task.key).is_some_and(|live| Arc::ptr_eq(live, task)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use selftalk_sim::Experiment;

    fn task(number: u8) -> Arc<Task> {
        let draw = Draw { replication: 0, generation: 0 };
        Task::new(UnitKey::from_bytes([number; 16]), Arc::new(Genotype::new([0_u16; 613])), draw, 2..5)
    }

    fn queue() -> (Queue, Study) {
        let queue = Queue::default();
        let study = queue.open(Simulator::new(&Experiment::default()).unwrap());
        (queue, study)
    }

    fn trials(queue: &Queue, study: Study) -> Vec<(UnitKey, u32)> {
        std::iter::from_fn(|| queue.next(study)).map(|job| (job.tag.0.key, job.tag.1)).collect()
    }

    #[test]
    fn trials_come_in_the_order_of_the_units() {
        let (queue, study) = queue();
        let (first, second) = (task(1), task(2));
        queue.push([(study, Arc::clone(&first))]);
        queue.push([(study, Arc::clone(&second))]);
        queue.push([(study, task(1))]);
        let (a, b) = (first.key, second.key);
        assert_eq!(trials(&queue, study), [(a, 2), (a, 3), (a, 4), (b, 2), (b, 3), (b, 4)]);
        assert_eq!(queue.live(), [a, b]);
    }

    #[test]
    fn a_unit_is_complete_with_its_last_outcome_in_any_order() {
        let unit = task(1);
        let outcome = |steps| TrialOutcome { score: 0.0, success: false, steps };
        assert_eq!(unit.note(4, outcome(4)), None);
        assert_eq!(unit.note(2, outcome(2)), None);
        assert_eq!(unit.note(2, outcome(2)), None);
        let steps: Vec<u32> = unit.note(3, outcome(3)).unwrap().iter().map(|outcome| outcome.steps).collect();
        assert_eq!(steps, [2, 3, 4]);
    }

    #[test]
    fn cancelled_units_are_dropped_and_may_come_again() {
        let (queue, study) = queue();
        let (first, second) = (task(1), task(2));
        queue.push([(study, Arc::clone(&first))]);
        queue.push([(study, Arc::clone(&second))]);
        assert_eq!(queue.next(study).map(|job| job.tag.1), Some(2));
        queue.cancel(&[first.key]);
        assert!(!queue.close(&first), "its answer is not wanted");
        queue.push([(study, task(1))]);
        assert_eq!(trials(&queue, study).len(), 6);
        assert!(!queue.close(&first), "it is another task under the same key");
        assert!(queue.close(&second));
    }

    #[test]
    fn slots_take_turns_between_experiments_and_end_when_stopped() {
        let (queue, one) = queue();
        let two = queue.open(Simulator::new(&Experiment::default()).unwrap());
        queue.push([(one, task(1))]);
        queue.push([(two, task(2))]);
        let turn = |last| queue.wait(last).map(|(study, _)| study);
        assert_eq!(turn(None), Some(one));
        assert_eq!(turn(Some(one)), Some(two));
        assert_eq!(turn(Some(two)), Some(one));
        queue.stop();
        assert_eq!(turn(None), None);
        assert!(queue.next(one).is_none());
    }
}
