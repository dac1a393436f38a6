//! The first generation.

use std::sync::Arc;

use rand::Rng;
use selftalk_sim::stream::{Purpose, StreamKey};
use selftalk_sim::{Experiment, Genotype};

use super::{Member, Origin, Population};

/// Generation 0 of a replication: `evolution.population` genotypes of `genes` genes, every bit drawn at random but
/// those that are inherited. Of these each of the experiment's ancestors gives equally many individuals all, or one
/// more than another where they do not divide the population (paper, section III.B).
#[must_use]
pub fn founders(experiment: &Experiment, genes: usize, replication: u32) -> Population {
    let population = experiment.evolution.population;
    let ancestors = &experiment.ancestors.genotypes;
    let member = |index: u32| {
        let key =
            StreamKey { seed: experiment.seed, replication, generation: 0, purpose: Purpose::Founder, index };
        let ancestor = u64::from(index) * ancestors.len() as u64 / u64::from(population);
        let mut whole = ancestors.get(ancestor as usize).map_or(Vec::new(), |of| of.genes().to_vec());
        let mut bytes = vec![0; genes.saturating_sub(whole.len()) * 2];
        key.stream().fill_bytes(&mut bytes);
        whole.extend(bytes.as_chunks().0.iter().copied().map(u16::from_le_bytes));
        Member { genotype: Arc::new(Genotype::new(whole)), origin: Origin::Founder }
    };
    Population { replication, generation: 0, members: (0..population).map(member).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evolution::distinct;

    #[test]
    fn founders_differ_from_each_other_and_between_replications_and_seeds() {
        let experiment = Experiment::default();
        let first = founders(&experiment, 613, 0);
        assert_eq!(first.members.len(), 100);
        assert_eq!(distinct(&first).len(), 100);
        assert_eq!(first, founders(&experiment, 613, 0));
        assert_ne!(first.members, founders(&experiment, 613, 1).members);
        let reseeded = Experiment { seed: 2, ..experiment };
        assert_ne!(first.members, founders(&reseeded, 613, 0).members);
    }

    #[test]
    fn ancestors_have_ten_heirs_each_whose_new_genes_differ() {
        let mut experiment = Experiment::default();
        experiment.ancestors.genotypes = (0..10).map(|ancestor| Genotype::new([ancestor; 7])).collect();
        let first = founders(&experiment, 10, 0);
        for (index, member) in first.members.iter().enumerate() {
            assert_eq!(member.genotype.genes()[..7], [index as u16 / 10; 7]);
            assert_eq!(member.genotype.genes().len(), 10);
        }
        assert_eq!(distinct(&first).len(), 100);
        let second = founders(&experiment, 10, 1);
        assert!(first.members.iter().zip(&second.members).all(|(one, other)| one.genotype != other.genotype));
        experiment.ancestors.genotypes.truncate(3);
        let uneven = founders(&experiment, 10, 0);
        let heirs =
            |ancestor| uneven.members.iter().filter(|member| member.genotype.genes()[0] == ancestor).count();
        assert_eq!([heirs(0), heirs(1), heirs(2)], [34, 33, 33]);
    }

    #[test]
    fn bits_are_fair() {
        let population = founders(&Experiment::default(), 613, 0);
        let genes = population.members.iter().flat_map(|member| member.genotype.genes());
        let mut ones = [0_u32; 16];
        for gene in genes {
            for (bit, count) in ones.iter_mut().enumerate() {
                *count += u32::from(gene >> bit & 1);
            }
        }
        // 61300 draws a bit: the standard deviation is 124.
        for count in ones {
            assert!(count.abs_diff(61_300 / 2) < 5 * 124, "{ones:?}");
        }
    }

    #[test]
    fn founders_keep_their_genes_across_releases() {
        let population = founders(&Experiment::default(), 3, 4);
        assert_eq!(population.members[5].genotype.genes(), GOLDEN);
    }

    const GOLDEN: [u16; 3] = [19_566, 5_595, 57_814];
}
