//! From one generation to the next.

use std::sync::Arc;

use rand::RngExt;
use selftalk_sim::controller::Layout;
use selftalk_sim::genotype::GENE_BITS;
use selftalk_sim::stream::{Purpose, StreamKey};
use selftalk_sim::{Experiment, Genotype};

use super::{Member, Origin, Population};

/// The next generation: each of the `evolution.parents` best has `evolution.offspring` children, the first an
/// unvaried copy, the others copies in which every bit flips with probability `evolution.mutation`, but for the bits
/// that are inherited from the experiment's ancestors.
///
/// `ranking` is a ranking of `population` ([`super::ranking`]), and the experiment one that was checked when read.
/// Children are ordered by their parents' rank.
#[must_use]
pub fn reproduce(experiment: &Experiment, population: &Population, ranking: &[u32]) -> Population {
    let evolution = &experiment.evolution;
    let (replication, generation) = (population.replication, population.generation + 1);
    let inherited = Layout::inherited(experiment);
    let parents = ranking.iter().take(evolution.parents as usize);
    let births = parents.flat_map(|&parent| (0..evolution.offspring).map(move |child| (parent, child == 0)));
    let members = (0..)
        .zip(births)
        .map(|(index, (parent, unvaried))| {
            let genotype = &population.members[parent as usize].genotype;
            if unvaried {
                return Member { genotype: Arc::clone(genotype), origin: Origin::Elite { parent } };
            }
            let purpose = Purpose::Mutation;
            let key = StreamKey { seed: experiment.seed, replication, generation, purpose, index };
            let (genotype, flipped) = vary(genotype, inherited, evolution.mutation, key);
            Member { genotype, origin: Origin::Varied { parent, flipped } }
        })
        .collect();
    Population { replication, generation, members }
}

/// A varied copy and the bits that flipped. One number is drawn for every bit from that of gene `first` on.
fn vary(genotype: &Arc<Genotype>, first: usize, mutation: f64, key: StreamKey) -> (Arc<Genotype>, Vec<u32>) {
    let mut stream = key.stream();
    let mut genes = genotype.genes().to_vec();
    let mut flipped = Vec::new();
    for (gene, lowest) in genes.iter_mut().zip((0..).step_by(GENE_BITS as usize)).skip(first) {
        for bit in 0..GENE_BITS {
            if stream.random_bool(mutation) {
                *gene ^= 1 << bit;
                flipped.push(lowest + bit);
            }
        }
    }
    let varied = if flipped.is_empty() { Arc::clone(genotype) } else { Arc::new(Genotype::new(genes)) };
    (varied, flipped)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evolution::founders;
    use selftalk_sim::experiment::Added;

    const GENES: usize = 613;

    /// The default experiment with another mutation probability.
    fn experiment(mutation: f64) -> Experiment {
        let mut experiment = Experiment::default();
        experiment.evolution.mutation = mutation;
        experiment
    }

    fn descending() -> Vec<u32> {
        (0..100).rev().collect()
    }

    #[test]
    fn the_best_twenty_have_one_copy_and_four_varied_children_each() {
        let experiment = experiment(0.0004);
        let parents = founders(&experiment, GENES, 3);
        let children = reproduce(&experiment, &parents, &descending());
        assert_eq!((children.replication, children.generation, children.members.len()), (3, 1, 100));
        for (index, child) in children.members.iter().enumerate() {
            let parent = 99 - index as u32 / 5;
            assert_eq!(child.origin.parent(), Some(parent));
            assert_eq!(matches!(child.origin, Origin::Elite { .. }), index % 5 == 0);
            let expected = parents.members[parent as usize].genotype.with_flipped(child.origin.flipped());
            assert_eq!(Ok(&*child.genotype), expected.as_ref());
        }
    }

    #[test]
    fn bits_flip_as_often_as_they_should() {
        let experiment = experiment(0.01);
        let children = reproduce(&experiment, &founders(&experiment, GENES, 0), &descending());
        let flips: usize = children.members.iter().map(|child| child.origin.flipped().len()).sum();
        // 80 varied children of 9808 bits: 7846 expected, standard deviation 88.
        assert!(flips.abs_diff(7846) < 5 * 88, "{flips}");
    }

    #[test]
    fn certain_and_impossible_mutations_are_taken_literally() {
        let parents = founders(&experiment(0.0), GENES, 0);
        let copies = reproduce(&experiment(0.0), &parents, &descending());
        assert_eq!(copies.members[1].origin, Origin::Varied { parent: 99, flipped: vec![] });
        assert_eq!(copies.members[1].genotype, parents.members[99].genotype);
        let inverted = reproduce(&experiment(1.0), &parents, &descending());
        assert!(inverted.members[1].origin.flipped().iter().copied().eq(0..9808));
    }

    #[test]
    fn inherited_bits_never_flip_unless_ancestors_evolve() {
        let mut experiment = experiment(1.0);
        experiment.controller.added = Added::Internal;
        experiment.ancestors.genotypes = vec![Genotype::new([7; GENES])];
        let parents = founders(&experiment, GENES + 148, 0);
        let children = reproduce(&experiment, &parents, &descending());
        let all_new = GENES as u32 * 16..(GENES as u32 + 148) * 16;
        assert!(children.members[1].origin.flipped().iter().copied().eq(all_new.clone()));
        assert_eq!(children.members[1].genotype.genes()[..GENES], [7; GENES]);
        experiment.ancestors.evolve = true;
        let children = reproduce(&experiment, &parents, &descending());
        assert!(children.members[1].origin.flipped().iter().copied().eq(0..all_new.end));
    }

    #[test]
    fn siblings_and_generations_vary_differently() {
        let experiment = experiment(0.01);
        let parents = founders(&experiment, GENES, 0);
        let children = reproduce(&experiment, &parents, &descending());
        assert_eq!(children, reproduce(&experiment, &parents, &descending()));
        assert_ne!(children.members[1].origin, children.members[2].origin);
        let later = Population { generation: 1, ..parents };
        assert_ne!(reproduce(&experiment, &later, &descending()).members, children.members);
    }

    #[test]
    fn mutations_stay_the_same_across_releases() {
        let experiment = experiment(0.0004);
        let children = reproduce(&experiment, &founders(&experiment, GENES, 0), &descending());
        assert_eq!(children.members[7].origin.flipped(), GOLDEN);
    }

    const GOLDEN: [u32; 6] = [3_713, 6_106, 6_372, 7_021, 7_656, 8_515];
}
