//! Whether a stored generation is what evolution and simulator give.

use std::collections::HashMap;
use std::fmt;

use selftalk_sim::{Experiment, Genotype, Simulator, TrialOutcome};

use crate::evolution::{Member, Origin, Population, distinct, founders, ranking, reproduce, score};
use crate::store::{BehaviourSummary, GenerationEntry, GenerationRecord, kept_bits};

/// Something stored that is not what it should be.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mismatch {
    /// The generation it is in.
    pub generation: u32,
    /// The individual it is about, unless it is about the generation.
    pub individual: Option<u32>,
    /// The trial it is about, unless it is about the individual.
    pub trial: Option<u32>,
    /// What is stored, and what should be.
    pub what: String,
}

impl fmt::Display for Mismatch {
    /// As it goes on after `EXPERIMENT/REPLICATION/`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.generation)?;
        self.individual.map_or(Ok(()), |individual| write!(f, "/{individual}"))?;
        self.trial.map_or(Ok(()), |trial| write!(f, ": trial {trial}"))?;
        write!(f, ": {}", self.what)
    }
}

/// A generation under examination.
struct Examination<'a> {
    record: &'a GenerationRecord,
    found: Vec<Mismatch>,
}

impl Examination<'_> {
    fn note(&mut self, individual: Option<u32>, what: String) {
        let generation = self.record.population.generation;
        self.found.push(Mismatch { generation, individual, trial: None, what });
    }

    /// Compares what is stored of the generation with what it should be.
    fn compare<T: PartialEq + fmt::Display>(&mut self, name: &str, stored: T, expected: T) {
        if stored != expected {
            self.note(None, format!("{name} {stored} is stored, {expected} is right"));
        }
    }
}

/// Everything about a generation that can be told without running a trial: that its individuals follow from the one
/// before, that fitness and successes follow from the stored outcomes, the ranking from those, and the summary from all.
///
/// `previous` is needed for every generation but the founders'; without it is not asked where the individuals come from.
#[must_use]
pub fn examine(
    experiment: &Experiment,
    simulator: &Simulator,
    previous: Option<&GenerationRecord>,
    record: &GenerationRecord,
    entry: &GenerationEntry,
    behaviours: &[BehaviourSummary],
) -> Vec<Mismatch> {
    let mut examination = Examination { record, found: Vec::new() };
    let Population { replication, generation, .. } = record.population;
    let expected = match previous {
        Some(previous) => Some(reproduce(experiment, &previous.population, &previous.ranking)),
        None if generation == 0 => Some(founders(experiment, simulator.gene_count(), replication)),
        None => None,
    };
    if let Some(expected) = expected {
        descent(&mut examination, &expected);
    }
    worth(&mut examination, simulator);
    order(&mut examination);
    summary(&mut examination, entry);
    by_behaviour(&mut examination, behaviours, &record.behaviours(experiment.task));
    examination.found
}

/// Where the individuals come from.
fn descent(examination: &mut Examination<'_>, expected: &Population) {
    let members = &examination.record.population.members;
    examination.compare("number of individuals", members.len(), expected.members.len());
    for (number, (stored, expected)) in (0..).zip(members.iter().zip(&expected.members)) {
        if stored.origin != expected.origin {
            let (stored, expected) = (origin(stored), origin(expected));
            examination.note(Some(number), format!("{stored} is stored, {expected} is right"));
        } else if stored.genotype != expected.genotype {
            examination.note(Some(number), "its genes are not those that evolution gives it".to_owned());
        }
    }
}

fn origin(member: &Member) -> String {
    match &member.origin {
        Origin::Founder => "a founder".to_owned(),
        Origin::Elite { parent } => format!("a copy of {parent}"),
        Origin::Varied { parent, flipped } => format!("a child of {parent} with bits {flipped:?} flipped"),
    }
}

/// That each distinct genotype was evaluated, and what it is worth.
fn worth(examination: &mut Examination<'_>, simulator: &Simulator) {
    let GenerationRecord { population, evaluated, scored, .. } = examination.record;
    if !evaluated.iter().map(|evaluated| evaluated.member).eq(distinct(population)) {
        examination.note(None, "the evaluations are not those of the distinct genotypes".to_owned());
        return;
    }
    let mut firsts: HashMap<&Genotype, u32> = HashMap::with_capacity(evaluated.len());
    for result in evaluated {
        firsts.insert(&*population.members[result.member as usize].genotype, result.member);
        let (stored, right) = (scored[result.member as usize], score(simulator, &result.outcomes));
        if result.outcomes.len() != simulator.trial_count() as usize {
            examination.note(Some(result.member), "trials are missing".to_owned());
        } else if kept_bits(stored.fitness) != kept_bits(right.fitness) {
            let (stored, right) = (stored.fitness, right.fitness);
            examination
                .note(Some(result.member), format!("fitness {stored} is stored, its trials come to {right}"));
        } else if stored.successes != right.successes {
            let (stored, right) = (stored.successes, right.successes);
            examination.note(
                Some(result.member),
                format!("{stored} successes are stored, its trials come to {right}"),
            );
        }
    }
    for (number, member) in (0..).zip(&population.members) {
        let first = firsts.get(&*member.genotype).copied();
        if first.is_some_and(|first| scored[number as usize] != scored[first as usize]) {
            examination.note(Some(number), "its fitness is not that of its genotype".to_owned());
        }
    }
}

fn order(examination: &mut Examination<'_>) {
    let GenerationRecord { scored, ranking: stored, .. } = examination.record;
    let right = ranking(scored);
    if let Some(rank) = stored.iter().zip(&right).position(|(stored, right)| stored != right) {
        let (stored, right) = (stored[rank], right[rank]);
        examination.note(Some(stored), format!("has rank {rank}, which belongs to individual {right}"));
    }
}

fn summary(examination: &mut Examination<'_>, entry: &GenerationEntry) {
    let Some(right) = examination.record.summary() else { return };
    let best = examination.record.ranking.first().copied().unwrap_or_default();
    examination.compare("best individual", entry.best_individual, best);
    examination.compare("best fitness", entry.best_fitness, right.best_fitness);
    examination.compare("successes of the best", entry.best_successes, right.best_successes);
    examination.compare("mean fitness", entry.mean_fitness, right.mean_fitness);
    examination.compare("most successes", entry.most_successes, right.most_successes);
    examination.compare("number of optimal individuals", entry.optimal_individuals, right.optimal);
    examination.compare("number of distinct genotypes", entry.distinct_genotypes, right.distinct);
}

/// What the best individual came to in each behaviour.
fn by_behaviour(examination: &mut Examination<'_>, stored: &[BehaviourSummary], right: &[BehaviourSummary]) {
    examination.compare("number of behaviours of the best", stored.len(), right.len());
    for (stored, right) in stored.iter().zip(right) {
        let behaviour = right.behaviour.name();
        let what = |what: &str| format!("{what} of the best in {behaviour}");
        examination.compare("behaviour of the best", stored.behaviour.name(), behaviour);
        examination.compare(&what("trials"), stored.trials, right.trials);
        examination.compare(&what("successes"), stored.successes, right.successes);
        // What a migration has added up, it may have added up in another order.
        if (stored.score - right.score).abs() > 1e-12 {
            examination.compare(&what("mean score"), stored.score, right.score);
        }
    }
}

/// In what an outcome differs from the stored one; none if it is the same to the last bit.
#[must_use]
pub fn difference(stored: &TrialOutcome, again: &TrialOutcome) -> Option<String> {
    if kept_bits(stored.score) != kept_bits(again.score) {
        Some(format!("score {} is stored, {} comes out", stored.score, again.score))
    } else if stored.success != again.success {
        let words = |success| if success { "success" } else { "no success" };
        Some(format!("{} is stored, {} comes out", words(stored.success), words(again.success)))
    } else if stored.steps != again.steps {
        Some(format!("{} steps are stored, {} come out", stored.steps, again.steps))
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evolution::Scored;
    use crate::store::Evaluated;

    /// Two generations of a small experiment with made-up outcomes.
    fn records() -> (Experiment, Simulator, Vec<GenerationRecord>) {
        let mut experiment = Experiment::default();
        experiment.evolution.population = 6;
        experiment.evolution.parents = 2;
        experiment.evolution.offspring = 3;
        experiment.evolution.mutation = 0.001;
        let simulator = Simulator::new(&experiment).unwrap();
        let evaluate = |population: Population| {
            let outcome = |member: u32, trial: u32| {
                let score = f64::from(1 + (7 * member + 3 * trial) % 11) / 12.0;
                TrialOutcome { score, success: score > 0.5, steps: 9 }
            };
            let evaluated: Vec<Evaluated> = distinct(&population)
                .into_iter()
                .map(|member| {
                    let outcomes = (0..16).map(|trial| outcome(member, trial)).collect();
                    Evaluated { member, outcomes, worker: None, failure: None }
                })
                .collect();
            let of = |member: &Member| -> Scored {
                let same = |e: &&Evaluated| population.members[e.member as usize].genotype == member.genotype;
                score(&simulator, &evaluated.iter().find(same).unwrap().outcomes)
            };
            let scored: Vec<Scored> = population.members.iter().map(of).collect();
            let ranking = ranking(&scored);
            GenerationRecord { population, evaluated, scored, ranking }
        };
        let first = evaluate(founders(&experiment, simulator.gene_count(), 1));
        let second = evaluate(reproduce(&experiment, &first.population, &first.ranking));
        (experiment, simulator, vec![first, second])
    }

    fn entry(record: &GenerationRecord) -> GenerationEntry {
        let summary = record.summary().unwrap();
        GenerationEntry {
            generation: record.population.generation,
            best_fitness: summary.best_fitness,
            mean_fitness: summary.mean_fitness,
            best_successes: summary.best_successes,
            most_successes: summary.most_successes,
            optimal_individuals: summary.optimal,
            distinct_genotypes: summary.distinct,
            best_individual: record.ranking[0],
            wall_ms: 0,
            committed_at: String::new(),
        }
    }

    #[test]
    fn what_evolution_wrote_has_no_mismatch() {
        let (experiment, simulator, records) = records();
        for (previous, record) in [(None, &records[0]), (Some(&records[0]), &records[1]), (None, &records[1])]
        {
            let behaviours = record.behaviours(experiment.task);
            assert_eq!(examine(&experiment, &simulator, previous, record, &entry(record), &behaviours), []);
        }
    }

    #[test]
    fn what_was_changed_is_found_and_named() {
        let (experiment, simulator, records) = records();
        type Change = fn(&mut GenerationRecord);
        let changes: [(Change, &str); 7] = [
            (
                |r| r.population.members[4].origin = Origin::Elite { parent: 3 },
                "1/4: a copy of 3 is stored, ",
            ),
            (|r| r.evaluated[2].outcomes[7].score += 1e-9, ": fitness 0."),
            (
                |r| r.scored[r.evaluated[1].member as usize].successes += 1,
                " successes are stored, its trials",
            ),
            (|r| r.evaluated[1].outcomes.truncate(15), ": trials are missing"),
            (|r| drop(r.evaluated.remove(0)), "1: the evaluations are not those of the distinct genotypes"),
            (|r| r.ranking.swap(2, 3), "has rank 2, which belongs to individual "),
            (|r| r.scored[r.ranking[5] as usize].fitness = 0.0, "1: mean fitness 0."),
        ];
        for (change, words) in changes {
            let mut changed = records[1].clone();
            change(&mut changed);
            let (entry, behaviours) = (entry(&records[1]), records[1].behaviours(experiment.task));
            let found = examine(&experiment, &simulator, Some(&records[0]), &changed, &entry, &behaviours);
            assert!(found.iter().any(|found| found.to_string().contains(words)), "{words}: {found:?}");
        }
        let right = entry(&records[0]);
        let summary = GenerationEntry {
            best_fitness: 2.0,
            best_successes: right.best_successes + 1,
            optimal_individuals: 3,
            ..right
        };
        let mut behaviours = records[0].behaviours(experiment.task);
        behaviours[1].successes += 1;
        behaviours[3].score += 1e-9;
        let found = examine(&experiment, &simulator, None, &records[0], &summary, &behaviours);
        let found: Vec<String> = found.iter().map(Mismatch::to_string).collect();
        assert_eq!(found.len(), 5, "{found:?}");
        assert!(found[0].contains("0: best fitness 2 is stored"), "{found:?}");
        assert!(found[1].contains("0: successes of the best"), "{found:?}");
        assert_eq!(found[2], "0: number of optimal individuals 3 is stored, 0 is right");
        assert!(found[3].contains("0: successes of the best in open"), "{found:?}");
        assert!(found[4].contains("0: mean score of the best in move"), "{found:?}");
    }

    #[test]
    fn outcomes_are_compared_to_the_last_bit() {
        let stored = TrialOutcome { score: 0.5, success: true, steps: 3 };
        assert_eq!(difference(&stored, &stored), None);
        let score = f64::from_bits(stored.score.to_bits() + 1);
        let words = difference(&stored, &TrialOutcome { score, ..stored }).unwrap();
        assert_eq!(words, "score 0.5 is stored, 0.5000000000000001 comes out");
        assert!(difference(&stored, &TrialOutcome { success: false, ..stored }).is_some());
        assert!(difference(&stored, &TrialOutcome { steps: 4, ..stored }).is_some());
        let nothing = TrialOutcome { score: f64::NAN, ..stored };
        assert_eq!(difference(&nothing, &TrialOutcome { score: f64::INFINITY, ..stored }), None);
    }
}
