//! Population, selection and reproduction: pure functions of the experiment and of what the trials came to.
//!
//! Nothing here is remembered between generations: [`founders`] starts a replication, [`reproduce`] makes each
//! population from the one before, and both draw from streams that are keyed by where the numbers are used.

mod fitness;
mod founders;
mod reproduce;

use std::collections::HashSet;
use std::sync::Arc;

use selftalk_sim::{Draw, Experiment, Genotype};

pub use fitness::{Scored, ranking, score};
pub use founders::founders;
pub use reproduce::reproduce;

/// An individual of a population.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Member {
    /// Its genes. Copies within a population need not share the allocation.
    pub genotype: Arc<Genotype>,
    /// Where the genes come from.
    pub origin: Origin,
}

/// Where an individual's genes come from. A parent is named by its index in the previous generation's population.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Origin {
    /// Drawn at random.
    Founder,
    /// An unvaried copy of its parent.
    Elite {
        /// The parent.
        parent: u32,
    },
    /// A copy of its parent in which every bit had its chance to flip.
    Varied {
        /// The parent.
        parent: u32,
        /// The bits that did flip, ascending; often none.
        flipped: Vec<u32>,
    },
}

impl Origin {
    /// The parent, which founders do not have.
    #[must_use]
    pub const fn parent(&self) -> Option<u32> {
        match self {
            Self::Founder => None,
            Self::Elite { parent } | Self::Varied { parent, .. } => Some(*parent),
        }
    }

    /// The bits in which the individual differs from its parent.
    #[must_use]
    pub fn flipped(&self) -> &[u32] {
        match self {
            Self::Founder | Self::Elite { .. } => &[],
            Self::Varied { flipped, .. } => flipped,
        }
    }

    /// Lower-case name of the kind of origin.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Founder => "founder",
            Self::Elite { .. } => "elite",
            Self::Varied { .. } => "varied",
        }
    }
}

/// The individuals of one generation of one replication.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Population {
    /// Replication, counted from 0.
    pub replication: u32,
    /// Generation, counted from 0.
    pub generation: u32,
    /// The individuals, `evolution.population` of them; an individual's number is its index.
    pub members: Vec<Member>,
}

/// The index of the first member that carries each distinct genotype, ascending: these are evaluated, the others
/// share their result.
#[must_use]
pub fn distinct(population: &Population) -> Vec<u32> {
    let mut seen = HashSet::with_capacity(population.members.len());
    (0..)
        .zip(&population.members)
        .filter(|(_, member)| seen.insert(&*member.genotype))
        .map(|(i, _)| i)
        .collect()
}

/// The draw that the individuals of a generation face: the last one made by then.
#[must_use]
pub fn draw(experiment: &Experiment, replication: u32, generation: u32) -> Draw {
    let every = experiment.evolution.draws_every.max(1);
    Draw { replication, generation: generation - generation % every }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn member(gene: u16) -> Member {
        Member { genotype: Arc::new(Genotype::new([gene])), origin: Origin::Founder }
    }

    #[test]
    fn copies_are_evaluated_once_as_their_first_carrier() {
        let members = [7, 7, 3, 7, 9, 3].map(member).to_vec();
        let population = Population { replication: 0, generation: 0, members };
        assert_eq!(distinct(&population), [0, 2, 4]);
    }

    #[test]
    fn a_draw_lasts_as_long_as_the_experiment_says() {
        let mut experiment = Experiment::default();
        experiment.evolution.draws_every = 1;
        assert_eq!(draw(&experiment, 2, 7), Draw { replication: 2, generation: 7 });
        experiment.evolution.draws_every = 3;
        let draws: Vec<u32> = (5..10).map(|generation| draw(&experiment, 0, generation).generation).collect();
        assert_eq!(draws, [3, 6, 6, 6, 9]);
    }
}
