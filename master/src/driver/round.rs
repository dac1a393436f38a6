//! One generation under way: its units at the workers, its results as they come in.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::Duration;

use selftalk_proto::{UnitKey, UnitKeys};
use selftalk_sim::{Draw, Genotype, TrialOutcome};
use tokio::sync::mpsc::UnboundedReceiver;
use tokio::time::Instant;
use tracing::Span;

use super::{DriverError, Study};
use crate::evolution::{Population, Scored, distinct, draw, score};
use crate::scheduler::Work;
use crate::service::{Handle, UnitEnd};
use crate::store::Evaluated;

/// What the genotypes of a generation came to: the next one need not run them again if it has the same draw.
#[derive(Debug, Default)]
pub(super) struct Known {
    draw: Option<Draw>,
    results: HashMap<Arc<Genotype>, Evaluated>,
}

impl Known {
    /// A result that was given up is not known: the genotype gets another chance.
    fn get(&self, draw: Draw, genotype: &Genotype) -> Option<&Evaluated> {
        let result = self.results.get(genotype).filter(|_| self.draw == Some(draw))?;
        result.failure.is_none().then_some(result)
    }
}

/// A generation whose distinct genotypes are being evaluated.
#[derive(Debug)]
pub(super) struct Round {
    pub(super) population: Population,
    /// The first member with each distinct genotype.
    distinct: Vec<u32>,
    /// Place of each unit in `distinct`.
    places: HashMap<UnitKey, usize>,
    ends: UnboundedReceiver<(UnitKey, UnitEnd)>,
    results: Vec<Option<Evaluated>>,
    begun: Instant,
    /// Lasts until the generation is committed.
    span: Span,
}

impl Round {
    /// Submits a generation, but for what is known.
    pub(super) async fn begin(study: &Study, handle: &Handle, population: Population, known: &Known) -> Self {
        let Population { replication, generation, .. } = population;
        let draw = draw(&study.experiment, replication, generation);
        let distinct = distinct(&population);
        let mut works = Vec::with_capacity(distinct.len());
        let mut places = HashMap::with_capacity(distinct.len());
        let mut results = vec![None; distinct.len()];
        let trials = 0..study.simulator.trial_count();
        let keys = UnitKeys::new(&study.toml, draw, &trials);
        for (place, &member) in distinct.iter().enumerate() {
            let genotype = Arc::clone(&population.members[member as usize].genotype);
            if let Some(result) = known.get(draw, &genotype) {
                results[place] = Some(Evaluated { member, ..result.clone() });
                continue;
            }
            let (key, trials) = (keys.of(&genotype), trials.clone());
            places.insert(key, place);
            works.push(Arc::new(Work { key, experiment: study.number, generation, draw, genotype, trials }));
        }
        let (experiment, units) = (&study.experiment.name, works.len());
        let span = tracing::info_span!("generation", experiment, replication, generation, units);
        let ends = handle.submit(works).await;
        Self { population, distinct, places, ends, results, begun: Instant::now(), span }
    }

    /// What is logged of it.
    pub(super) fn span(&self) -> Span {
        self.span.clone()
    }

    /// Waits until every unit has ended. Can be dropped and called again.
    pub(super) async fn complete(&mut self, study: &Study) -> Result<(), DriverError> {
        while !self.places.is_empty() {
            let (key, end) = self.ends.recv().await.ok_or(DriverError::ServiceEnded)?;
            if let Some(place) = self.places.remove(&key) {
                self.results[place] = Some(evaluated(study, self.distinct[place], end));
            }
        }
        Ok(())
    }

    /// The results in the order of the distinct genotypes, and what each member is worth.
    pub(super) fn scored(&mut self, study: &Study) -> (Vec<Evaluated>, Vec<Scored>) {
        let results: Vec<Evaluated> = self.results.drain(..).flatten().collect();
        let mut worth: HashMap<&Genotype, Scored> = HashMap::with_capacity(results.len());
        for result in &results {
            let genotype = &*self.population.members[result.member as usize].genotype;
            worth.insert(genotype, score(&study.simulator, &result.outcomes));
        }
        let nothing = Scored { fitness: 0.0, successes: 0 };
        let members = self.population.members.iter();
        let scored = members.map(|member| worth.get(&*member.genotype).copied().unwrap_or(nothing)).collect();
        (results, scored)
    }

    /// What the next generation need not find out again: nothing if it has another draw.
    pub(super) fn known(&self, study: &Study, results: &[Evaluated]) -> Known {
        let Population { replication, generation, members } = &self.population;
        let [now, next] = [0, 1].map(|later| draw(&study.experiment, *replication, generation + later));
        if now != next {
            return Known::default();
        }
        let genotype = |result: &Evaluated| Arc::clone(&members[result.member as usize].genotype);
        Known {
            draw: Some(now),
            results: results.iter().map(|result| (genotype(result), result.clone())).collect(),
        }
    }

    /// Time since the generation was submitted.
    pub(super) fn wall(&self) -> Duration {
        self.begun.elapsed()
    }
}

fn evaluated(study: &Study, member: u32, end: UnitEnd) -> Evaluated {
    match end {
        UnitEnd::Evaluated { outcomes, worker } => Evaluated { member, outcomes, worker, failure: None },
        UnitEnd::SetAside { losses, reason } => {
            let nothing = TrialOutcome { score: 0.0, success: false, steps: 0 };
            let outcomes = vec![nothing; study.simulator.trial_count() as usize];
            let reason = reason.unwrap_or_else(|| "the workers were lost".to_owned());
            let failure = Some(format!("set aside after {losses} losses: {reason}"));
            Evaluated { member, outcomes, worker: None, failure }
        }
    }
}
