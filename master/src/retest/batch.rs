//! Many trials on many threads.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use selftalk_sim::{Case, Draw, Genotype, Job, Simulator, TrialOutcome};

use super::RetestError;

/// A trial to be run.
#[derive(Debug, Clone)]
pub struct Task {
    /// The genotype under test.
    pub genotype: Arc<Genotype>,
    /// Which trial.
    pub case: Case,
}

impl Task {
    /// All trials of a genotype in one draw, in order.
    pub fn all(simulator: &Simulator, genotype: &Arc<Genotype>, draw: Draw) -> impl Iterator<Item = Self> {
        let genotype = Arc::clone(genotype);
        (0..simulator.trial_count())
            .map(move |trial| Self { genotype: Arc::clone(&genotype), case: Case::Drawn { draw, trial } })
    }
}

/// The threads that run trials.
#[derive(Clone, Copy)]
pub struct Crew<'a> {
    /// How many; at least one is used.
    pub threads: u32,
    /// Called after each trial.
    pub done: &'a (dyn Fn() + Sync),
}

impl fmt::Debug for Crew<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Crew").field("threads", &self.threads).finish_non_exhaustive()
    }
}

/// Runs trials and returns their outcomes in the order of the tasks.
///
/// # Errors
/// [`RetestError`] when a task does not fit the experiment.
pub fn run(simulator: &Simulator, tasks: &[Task], crew: Crew<'_>) -> Result<Vec<TrialOutcome>, RetestError> {
    let next = AtomicUsize::new(0);
    let work = || {
        let mut outcomes = Vec::new();
        let job = || {
            let tag = next.fetch_add(1, Ordering::Relaxed);
            let Task { genotype, case } = tasks.get(tag)?.clone();
            Some(Job { genotype, case, tag })
        };
        let done = |tag: usize, outcome| {
            outcomes.push((tag, outcome));
            (crew.done)();
        };
        simulator.run(job, done).map(|()| outcomes)
    };
    let parts: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..crew.threads.max(1)).map(|_| scope.spawn(work)).collect();
        threads.into_iter().map(std::thread::ScopedJoinHandle::join).collect()
    });
    let mut outcomes = vec![None; tasks.len()];
    for part in parts {
        for (index, outcome) in part.map_err(|_| RetestError::Panicked)?? {
            outcomes[index] = Some(outcome);
        }
    }
    outcomes.into_iter().collect::<Option<_>>().ok_or(RetestError::Panicked)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::retest::tests::brief;
    use selftalk_sim::Experiment;

    #[test]
    fn outcomes_are_those_of_the_simulator_however_many_threads_there_are() {
        let simulator = Simulator::new(&brief(5)).unwrap();
        let genotype = |gene: u16| Arc::new(Genotype::new(vec![gene; simulator.gene_count()]));
        let (genotypes, draw) = ([20_000, 40_000].map(genotype), Draw::test(3));
        let tasks: Vec<Task> =
            genotypes.iter().flat_map(|genotype| Task::all(&simulator, genotype, draw)).collect();
        let expected: Vec<TrialOutcome> = genotypes
            .iter()
            .flat_map(|genotype| simulator.evaluate(genotype, draw, 0..16).unwrap())
            .collect();
        for threads in [0, 1, 3] {
            let count = AtomicUsize::new(0);
            let done = || {
                count.fetch_add(1, Ordering::Relaxed);
            };
            let outcomes = run(&simulator, &tasks, Crew { threads, done: &done }).unwrap();
            assert_eq!(outcomes, expected);
            assert_eq!(count.into_inner(), 32);
        }
    }

    #[test]
    fn what_does_not_fit_is_an_error() {
        let simulator = Simulator::new(&Experiment::default()).unwrap();
        let case = Case::Drawn { draw: Draw::test(0), trial: 0 };
        let task = Task { genotype: Arc::new(Genotype::new([1])), case };
        let failed = run(&simulator, &[task], Crew { threads: 2, done: &|| {} });
        assert!(matches!(failed, Err(RetestError::Sim(_))), "{failed:?}");
    }
}
