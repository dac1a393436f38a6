//! The tests that robots of the second phase are put to (paper, sections III.B to III.E).

use std::collections::HashMap;
use std::sync::Arc;

use selftalk_sim::experiment::Speaks;
use selftalk_sim::{Case, Draw, Experiment, Genotype, Simulator, TrialOutcome};

use super::RetestError;
use super::batch::{Crew, Task, run};
use crate::store::Test;

/// Draws of post-evaluation: 40 trials (paper, section III.B).
const POST_DRAWS: u32 = 5;

/// The trials of a test.
#[must_use]
pub fn cases(simulator: &Simulator, test: Test) -> Vec<Case> {
    match test {
        Test::Post => {
            let draws = (0..POST_DRAWS).map(Draw::test);
            draws
                .flat_map(|draw| (0..simulator.trial_count()).map(move |trial| Case::Drawn { draw, trial }))
                .collect()
        }
        Test::Generalisation | Test::Aided => {
            (0..Case::GRID_TRIALS).map(|number| Case::Grid { number }).collect()
        }
    }
}

/// Puts genotypes of an experiment to a test and returns their outcomes in order. Equal genotypes are run once.
///
/// # Errors
/// [`RetestError`] when a genotype does not fit the experiment.
pub fn battery(
    experiment: &Experiment,
    test: Test,
    genotypes: &[Arc<Genotype>],
    crew: Crew<'_>,
) -> Result<Vec<Vec<TrialOutcome>>, RetestError> {
    let mut experiment = experiment.unaided();
    if test == Test::Aided {
        experiment.caretaker.speaks = Speaks::Always;
    }
    let simulator = Simulator::new(&experiment)?;
    let cases = cases(&simulator, test);
    let mut places: HashMap<&Genotype, usize> = HashMap::new();
    let mut tasks = Vec::new();
    for genotype in genotypes {
        let next = places.len();
        if *places.entry(genotype).or_insert(next) == next {
            tasks.extend(cases.iter().map(|case| Task { genotype: Arc::clone(genotype), case: *case }));
        }
    }
    let outcomes = run(&simulator, &tasks, crew)?;
    let of = |genotype: &Arc<Genotype>| {
        let place = places.get(&**genotype).copied().unwrap_or_default();
        outcomes.chunks(cases.len()).nth(place).unwrap_or_default().to_vec()
    };
    Ok(genotypes.iter().map(of).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// A condition in which the caretaker speaks, with short trials.
    fn experiment() -> Experiment {
        let overrides = [
            "task=move-to-target",
            "controller.added=speech",
            "caretaker.speaks=even",
            "move_to_target.steps=4",
            "physics.substeps=4",
        ];
        Experiment::from_toml("x", "", &overrides.map(str::to_owned)).unwrap()
    }

    #[test]
    fn post_evaluation_has_40_trials_and_generalisation_196() {
        let simulator = Simulator::new(&experiment()).unwrap();
        assert_eq!(cases(&simulator, Test::Post).len(), 40);
        assert_eq!(cases(&simulator, Test::Generalisation).len(), 196);
    }

    #[test]
    fn equal_genotypes_are_run_once_and_each_gets_its_own() {
        let experiment = experiment();
        let genes = Simulator::new(&experiment).unwrap().gene_count();
        let genotype = |gene: u16| Arc::new(Genotype::new(vec![gene; genes]));
        let all = [9_000, 50_000, 9_000].map(genotype);
        let count = AtomicUsize::new(0);
        let done = || {
            count.fetch_add(1, Ordering::Relaxed);
        };
        let outcomes = battery(&experiment, Test::Post, &all, Crew { threads: 2, done: &done }).unwrap();
        assert_eq!(count.into_inner(), 80);
        assert_eq!(outcomes[0], outcomes[2]);
        assert_ne!(outcomes[0], outcomes[1]);
        let unaided = Simulator::new(&experiment.unaided()).unwrap();
        assert_eq!(outcomes[1][8..16], unaided.evaluate(&all[1], Draw::test(1), 0..8).unwrap());
    }
}
