//! Which individual stands for a replication.
//!
//! A generation's best individual may owe its rank to that generation's draw. So the best individuals of the last
//! generations are run in draws that no evolution used, the same for all, and the one that succeeds most often stands
//! for the replication. How good it is has to be told by yet other draws, as these have chosen it.

use std::sync::Arc;

use selftalk_sim::{Draw, Genotype, Simulator};

use super::RetestError;
use super::batch::Crew;
use super::tally::{Tally, tallies};

/// Generations whose best individuals are candidates: the last ones.
pub const CANDIDATES: u32 = 50;
/// Draws in which each candidate runs all trials.
pub const VALIDATION_DRAWS: u32 = 10;

/// The best individual of a generation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Candidate {
    /// Its generation.
    pub generation: u32,
    /// Its number in the generation.
    pub individual: u32,
    /// Its genes.
    pub genotype: Arc<Genotype>,
}

/// The candidate that was chosen.
#[derive(Debug, Clone, PartialEq)]
pub struct Champion {
    /// Who it is.
    pub candidate: Candidate,
    /// What its validation came to.
    pub validation: Tally,
}

/// The candidate with most successes in the validation draws; of several the one with the highest mean score, and of
/// those the latest. None without candidates.
///
/// # Errors
/// [`RetestError`] when a genotype does not fit the experiment.
pub fn champion(
    simulator: &Simulator,
    candidates: &[Candidate],
    crew: Crew<'_>,
) -> Result<Option<Champion>, RetestError> {
    // The best are often copies of the best before: each genotype is run once, for the latest that carries it.
    let later = |at: usize| candidates[at + 1..].iter().map(|candidate| &candidate.genotype);
    let distinct: Vec<&Candidate> = candidates
        .iter()
        .enumerate()
        .filter(|(at, candidate)| !later(*at).any(|genotype| *genotype == candidate.genotype))
        .map(|(_, candidate)| candidate)
        .collect();
    let genotypes: Vec<_> = distinct.iter().map(|candidate| Arc::clone(&candidate.genotype)).collect();
    let draws: Vec<Draw> = (0..VALIDATION_DRAWS).map(Draw::validation).collect();
    let validations = tallies(simulator, &genotypes, &draws, crew)?;
    let score = |tally: &Tally| {
        simulator.behaviours().iter().map(|behaviour| tally.score_of(*behaviour)).sum::<f64>()
    };
    let best = distinct.into_iter().zip(validations).max_by(|(_, a), (_, b)| {
        a.successes().cmp(&b.successes()).then_with(|| score(a).total_cmp(&score(b)))
    });
    Ok(best.map(|(candidate, validation)| Champion { candidate: candidate.clone(), validation }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::retest::tests::brief;
    use selftalk_sim::Behaviour;

    #[test]
    fn the_best_in_the_validation_draws_is_chosen_and_of_equals_the_latest() {
        // Whoever moves its hand a little more or less differs in score.
        let simulator = Simulator::new(&brief(3)).unwrap();
        let candidate = |generation: u32, gene: u16| Candidate {
            generation,
            individual: 0,
            genotype: Arc::new(Genotype::new(vec![gene; simulator.gene_count()])),
        };
        let crew = Crew { threads: 2, done: &|| {} };
        let (a, b) = (candidate(1, 20_000), candidate(2, 40_000));
        let draws: Vec<Draw> = (0..VALIDATION_DRAWS).map(Draw::validation).collect();
        let genotypes = [&a, &b].map(|candidate| Arc::clone(&candidate.genotype));
        let both = tallies(&simulator, &genotypes, &draws, crew).unwrap();
        let value = |tally: &Tally| {
            (tally.successes(), Behaviour::ELEMENTARY.iter().map(|of| tally.score_of(*of)).sum::<f64>())
        };
        let (better, tally) =
            if value(&both[0]) > value(&both[1]) { (20_000, both[0]) } else { (40_000, both[1]) };
        assert_ne!(both[0], both[1]);
        let candidates = [a, b, candidate(3, better), candidate(4, 1)];
        let chosen = champion(&simulator, &candidates[..3], crew).unwrap().unwrap();
        assert_eq!(chosen, Champion { candidate: candidate(3, better), validation: tally });
        assert_eq!(champion(&simulator, &[], crew), Ok(None));
    }
}
