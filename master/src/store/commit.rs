//! What a generation has to be before it is written, and what it adds up to.

use std::collections::{BTreeMap, HashMap};

use selftalk_sim::experiment::Task;
use selftalk_sim::{Behaviour, Genotype, TrialOutcome};
use sha2::{Digest, Sha256};

use super::read::Position;
use super::{BehaviourSummary, Evaluated, GenerationCommit, GenerationRecord, GenerationSummary};
use crate::evolution::{Population, Scored, distinct};

/// A generation whose parts fit together.
pub(super) struct Checked<'a> {
    pub(super) commit: GenerationCommit<'a>,
    pub(super) summary: GenerationSummary,
    /// What the best individual came to.
    pub(super) behaviours: Vec<BehaviourSummary>,
    /// For every member the first one with the same genotype.
    pub(super) evaluated_as: Vec<u32>,
}

impl<'a> Checked<'a> {
    /// Refuses, with the reason, what does not go on where the replication is or would not read back as it is.
    pub(super) fn new(commit: GenerationCommit<'a>, at: Position) -> Result<Self, String> {
        let GenerationCommit { population, evaluated, scored, ranking, .. } = commit;
        let Population { replication, generation, .. } = *population;
        if at.finished {
            return Err(format!("replication {} is finished", at.number));
        }
        if (replication, generation) != (at.number, at.generations) {
            let Position { number, generations, .. } = at;
            return Err(format!(
                "it is generation {generation} of replication {replication}, not {generations} of {number}"
            ));
        }
        let size = population.members.len();
        let carriers = distinct(population);
        if !evaluated.iter().map(|evaluated| evaluated.member).eq(carriers.iter().copied()) {
            return Err("the results are not those of the distinct genotypes".to_owned());
        }
        if scored.len() != size || scored.iter().any(|scored| !scored.fitness.is_finite()) {
            return Err("not every individual has a fitness".to_owned());
        }
        if !is_permutation(ranking, size) {
            return Err("the ranking does not name every individual once".to_owned());
        }
        let Some(&best) = ranking.first() else {
            return Err("there are no individuals".to_owned());
        };
        let evaluated_as = evaluated_as(population, &carriers);
        for (scored_member, &first) in scored.iter().zip(&evaluated_as) {
            if *scored_member != scored[first as usize] {
                return Err(format!("individuals with the genotype of number {first} have different scores"));
            }
        }
        let summary = summary(evaluated, scored, best, &evaluated_as);
        let behaviours = behaviours(commit.task, evaluated, best, &evaluated_as);
        Ok(Self { commit, summary, behaviours, evaluated_as })
    }
}

/// What a generation adds up to, whose fittest individual is `best`.
fn summary(evaluated: &[Evaluated], scored: &[Scored], best: u32, evaluated_as: &[u32]) -> GenerationSummary {
    let best = scored[best as usize];
    GenerationSummary {
        best_fitness: best.fitness,
        mean_fitness: scored.iter().map(|scored| scored.fitness).sum::<f64>() / scored.len() as f64,
        best_successes: best.successes,
        most_successes: scored.iter().map(|scored| scored.successes).max().unwrap_or_default(),
        optimal: optimal(evaluated, evaluated_as),
        distinct: evaluated.len() as u32,
    }
}

/// What the trials of the fittest individual, `best`, came to, in the order of the behaviours.
fn behaviours(task: Task, evaluated: &[Evaluated], best: u32, evaluated_as: &[u32]) -> Vec<BehaviourSummary> {
    let first = evaluated_as[best as usize];
    let outcomes = evaluated.iter().find(|evaluated| evaluated.member == first);
    let mut trials: BTreeMap<Behaviour, Vec<&TrialOutcome>> = BTreeMap::new();
    for (trial, outcome) in (0..).zip(outcomes.map_or(&[][..], |evaluated| &evaluated.outcomes)) {
        trials.entry(Behaviour::of_trial(task, trial)).or_default().push(outcome);
    }
    let summary = |(behaviour, outcomes): (Behaviour, Vec<&TrialOutcome>)| {
        let scores = outcomes.iter().map(|outcome| outcome.score).filter(|score| score.is_finite());
        BehaviourSummary {
            behaviour,
            trials: outcomes.len() as u32,
            successes: outcomes.iter().filter(|outcome| outcome.success).count() as u32,
            score: scores.sum::<f64>() / outcomes.len() as f64,
        }
    };
    trials.into_iter().map(summary).collect()
}

impl GenerationRecord {
    /// What its best individual came to in trials of a task; nothing without individuals.
    #[must_use]
    pub fn behaviours(&self, task: Task) -> Vec<BehaviourSummary> {
        let Self { population, evaluated, ranking, .. } = self;
        let evaluated_as = evaluated_as(population, &distinct(population));
        ranking.first().map_or_else(Vec::new, |best| behaviours(task, evaluated, *best, &evaluated_as))
    }

    /// What it adds up to; none without individuals.
    #[must_use]
    pub fn summary(&self) -> Option<GenerationSummary> {
        let Self { population, evaluated, scored, ranking } = self;
        let evaluated_as = evaluated_as(population, &distinct(population));
        Some(summary(evaluated, scored, *ranking.first()?, &evaluated_as))
    }
}

pub(super) fn is_permutation(ranking: &[u32], size: usize) -> bool {
    let mut seen = vec![false; size];
    let fresh =
        |&index: &u32| seen.get_mut(index as usize).is_some_and(|seen| !std::mem::replace(seen, true));
    ranking.len() == size && ranking.iter().all(fresh)
}

fn evaluated_as(population: &Population, carriers: &[u32]) -> Vec<u32> {
    let firsts: HashMap<&Genotype, u32> =
        carriers.iter().map(|&first| (&*population.members[first as usize].genotype, first)).collect();
    population.members.iter().map(|member| firsts[&*member.genotype]).collect()
}

/// Individuals that succeeded in all trials.
fn optimal(evaluated: &[Evaluated], evaluated_as: &[u32]) -> u32 {
    let perfect = |evaluated: &Evaluated| {
        !evaluated.outcomes.is_empty() && evaluated.outcomes.iter().all(|outcome| outcome.success)
    };
    let perfect: Vec<u32> =
        evaluated.iter().filter(|evaluated| perfect(evaluated)).map(|evaluated| evaluated.member).collect();
    evaluated_as.iter().filter(|first| perfect.binary_search(first).is_ok()).count() as u32
}

/// SHA-256 over all individuals' genes in order.
pub(super) fn genotypes_sha256(population: &Population) -> [u8; 32] {
    let mut hash = Sha256::new();
    for member in &population.members {
        hash.update(member.genotype.to_bytes());
    }
    hash.finalize().into()
}
