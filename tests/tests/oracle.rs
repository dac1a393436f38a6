//! The history of an experiment is what a plain loop on one thread computes.

use std::sync::Arc;

use selftalk::evolution::{distinct, founders, ranking, reproduce, score};
use selftalk::store::{Evaluated, GenerationRecord, HistoryDigest};
use selftalk_sim::physics::Instructions;
use selftalk_sim::{Draw, Experiment, Simulator};
use selftalk_tests::{GOLDEN, SMALL};

/// The digest of a replication, without workers, network or database.
fn digest(instructions: Instructions, replication: u32) -> String {
    let experiment = Experiment::from_toml("small.toml", SMALL, &[]).unwrap();
    let simulator = Simulator::with_instructions(&experiment, instructions).unwrap();
    let mut digest = HistoryDigest::new();
    let mut population = founders(&experiment, simulator.gene_count(), replication);
    for generation in 0..experiment.generations {
        // Drawn anew in every so many generations.
        let draw =
            Draw { replication, generation: generation - generation % experiment.evolution.draws_every };
        let evaluate = |member: &u32| {
            let genotype = Arc::clone(&population.members[*member as usize].genotype);
            let outcomes = simulator.evaluate(&genotype, draw, 0..simulator.trial_count()).unwrap();
            Evaluated { member: *member, outcomes, worker: None, failure: None }
        };
        let evaluated: Vec<Evaluated> = distinct(&population).iter().map(evaluate).collect();
        let scored: Vec<_> = population
            .members
            .iter()
            .map(|member| {
                let same = |e: &&Evaluated| population.members[e.member as usize].genotype == member.genotype;
                score(&simulator, &evaluated.iter().find(same).unwrap().outcomes)
            })
            .collect();
        let ranking = ranking(&scored);
        let next = reproduce(&experiment, &population, &ranking);
        let population = std::mem::replace(&mut population, next);
        digest.update(&GenerationRecord { population, evaluated, scored, ranking });
    }
    digest.finish()
}

#[test]
fn the_golden_digest_is_that_of_a_plain_loop() {
    assert_eq!([0, 1].map(|replication| digest(Instructions::Best, replication)), GOLDEN);
}

#[test]
fn the_golden_digest_is_that_of_the_plainest_machine() {
    assert_eq!([0, 1].map(|replication| digest(Instructions::Baseline, replication)), GOLDEN);
}
