//! From what is named on the command line to stored individuals.

use selftalk_sim::{Draw, Experiment, Simulator, fingerprint};

use super::args::Which;
use super::reference::{Name, Reference};
use super::select;
use crate::evolution::{Member, Scored, draw};
use crate::exit::{Exit, Failure};
use crate::retest::{CANDIDATES, Candidate, Crew, Tally, champion};
use crate::store::{
    Evaluated, GenerationRecord, ReplicationId, SqliteStore, StoredExperiment, StoredReplication,
};

/// A stored individual.
#[derive(Debug, Clone, PartialEq)]
pub struct Individual {
    /// Its name.
    pub name: Name,
    /// Its experiment.
    pub experiment: Experiment,
    /// The simulator with which that was run.
    pub fingerprint: String,
    /// Key of its replication.
    pub replication: ReplicationId,
    /// Its rank in its generation.
    pub rank: u32,
    /// Its genes and where they come from.
    pub member: Member,
    /// What its trials came to.
    pub evaluated: Evaluated,
    /// What it was worth.
    pub scored: Scored,
    /// What it came to in the validation draws, if it was chosen by them.
    pub validation: Option<Tally>,
}

impl Individual {
    /// The individual of a generation that has this number; none if there is none.
    pub(super) fn of(
        stored: &StoredExperiment,
        replication: &StoredReplication,
        record: &GenerationRecord,
        number: u32,
    ) -> Option<Self> {
        let members = &record.population.members;
        let member = members.get(number as usize)?.clone();
        // Copies were evaluated as the first of them.
        let same = |evaluated: &&Evaluated| {
            members.get(evaluated.member as usize).is_some_and(|other| other.genotype == member.genotype)
        };
        let rank = record.ranking.iter().position(|ranked| *ranked == number)?;
        Some(Self {
            name: Name {
                experiment: stored.experiment.name.clone(),
                replication: replication.number,
                generation: record.population.generation,
                individual: number,
            },
            experiment: stored.experiment.clone(),
            fingerprint: stored.fingerprint.clone(),
            replication: replication.id,
            rank: rank as u32,
            evaluated: record.evaluated.iter().find(same)?.clone(),
            scored: *record.scored.get(number as usize)?,
            member,
            validation: None,
        })
    }

    /// The draw in which it was evaluated.
    #[must_use]
    pub fn draw(&self) -> Draw {
        draw(&self.experiment, self.name.replication, self.name.generation)
    }
}

/// The individuals that are meant, each once, in the order they are named.
///
/// # Errors
/// [`Exit::Usage`] when a name is none or there is no such individual.
pub async fn find(store: &SqliteStore, which: &Which, crew: Crew<'_>) -> Result<Vec<Individual>, Failure> {
    let references: Vec<Reference> =
        which.individuals.iter().map(|text| Reference::parse(text)).collect::<Result<_, _>>()?;
    let mut found: Vec<Individual> = Vec::new();
    for reference in references {
        let meant = match reference {
            Reference::Named(name) => vec![named(store, name).await?],
            Reference::Best => all(store, which, None).await?,
            Reference::Champion => all(store, which, Some(crew)).await?,
        };
        for individual in meant {
            if !found.iter().any(|other| other.name == individual.name) {
                found.push(individual);
            }
        }
    }
    if found.is_empty() {
        return Err(Failure::new(
            Exit::Usage,
            "there are no individuals yet; `selftalk run` or `selftalk resume` makes some",
        ));
    }
    Ok(found)
}

/// The one of this name.
async fn named(store: &SqliteStore, name: Name) -> Result<Individual, Failure> {
    let there = |failure: Failure| Failure::new(failure.exit, format!("{name}: {failure}"));
    let mut experiments = select::experiments(store, Some(&name.experiment)).await.map_err(there)?;
    let replications = experiments.first().map_or(0, |stored| stored.replications.len());
    for stored in &mut experiments {
        stored.replications.retain(|replication| replication.number == name.replication);
    }
    let found = experiments.first().and_then(|stored| Some((stored, stored.replications.first()?)));
    let missing = |what, number, count| there(select::missing(what, number, count));
    let (stored, replication) =
        found.ok_or_else(|| missing("replication", name.replication, replications))?;
    if name.generation >= replication.generations {
        return Err(missing("generation", name.generation, replication.generations as usize));
    }
    let record = store.generations(replication).read(name.generation).await?;
    let count = record.population.members.len();
    Individual::of(stored, replication, &record, name.individual)
        .ok_or_else(|| missing("individual", name.individual, count))
}

/// The best individual of the generation asked for in each replication asked for, or, with somebody to choose it, the
/// champion up to there.
async fn all(store: &SqliteStore, which: &Which, crew: Option<Crew<'_>>) -> Result<Vec<Individual>, Failure> {
    let experiments = select::replications(store, &which.of).await?;
    let mut found = Vec::new();
    for (stored, replication, generation) in select::generations(&experiments, which.generation)? {
        found.extend(match crew {
            Some(crew) => chosen(store, stored, replication, generation, crew).await?,
            None => {
                let record = store.generations(replication).read(generation).await?;
                let best = record.ranking.first();
                best.and_then(|best| Individual::of(stored, replication, &record, *best))
            }
        });
    }
    Ok(found)
}

/// The champion of a replication, among the best individuals up to a generation.
pub(super) async fn chosen(
    store: &SqliteStore,
    stored: &StoredExperiment,
    replication: &StoredReplication,
    last: u32,
    crew: Crew<'_>,
) -> Result<Option<Individual>, Failure> {
    let mut generations = store.generations(replication);
    let mut best = Vec::new();
    for generation in last.saturating_sub(CANDIDATES - 1)..=last {
        let record = generations.read(generation).await?;
        let first = record.ranking.first();
        best.extend(first.and_then(|first| Individual::of(stored, replication, &record, *first)));
    }
    let candidate = |individual: &Individual| Candidate {
        generation: individual.name.generation,
        individual: individual.name.individual,
        genotype: individual.member.genotype.clone(),
    };
    let candidates: Vec<Candidate> = best.iter().map(candidate).collect();
    let simulator = Simulator::new(&stored.experiment.unaided())?;
    let Some(chosen) = champion(&simulator, &candidates, crew)? else { return Ok(None) };
    let found = best.into_iter().find(|individual| individual.name.generation == chosen.candidate.generation);
    Ok(found.map(|individual| Individual { validation: Some(chosen.validation), ..individual }))
}

/// Says that this program's simulator is not the one that an experiment was run with, if so.
pub(super) fn foreign(name: &str, begun: &str) -> Result<Option<String>, Failure> {
    let ours = fingerprint()?;
    Ok((begun != ours).then(|| {
        format!(
            "experiment `{name}` was run with a simulator that gives other results (fingerprint {begun}, this \
             release has {ours})"
        )
    }))
}

/// Warns on stderr about experiments that another simulator has run.
///
/// # Errors
/// [`Exit::Unexpected`] when this program's simulator is damaged.
pub(super) fn warn_foreign(individuals: &[Individual]) -> Result<(), Failure> {
    let mut told: Vec<&str> = Vec::new();
    for individual in individuals {
        let name = individual.name.experiment.as_str();
        if !told.contains(&name) {
            told.push(name);
            if let Some(words) = foreign(name, &individual.fingerprint)? {
                eprintln!("warning: {words}");
            }
        }
    }
    Ok(())
}
