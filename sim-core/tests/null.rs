//! `engine = "null"`: outcomes without trials.

use selftalk_sim::experiment::{Engine, Experiment};
use selftalk_sim::physics::EngineError;
use selftalk_sim::{Case, Draw, Genotype, SimError, Simulator};

#[test]
fn outcomes_depend_on_genes_draw_trial_and_seed_and_are_better_with_more_ones() {
    let experiment = |seed| Experiment { engine: Engine::Null, seed, ..Experiment::default() };
    let simulator = Simulator::new(&experiment(1)).unwrap();
    let genotype = |gene: u16, last: u16| {
        let mut genes = vec![gene; simulator.gene_count()];
        *genes.last_mut().unwrap() = last;
        Genotype::new(genes)
    };
    let draw = |replication, generation| Draw { replication, generation };
    let evaluate = |genotype: &Genotype, draw| simulator.evaluate(genotype, draw, 0..16).unwrap();
    let (one, two) = (genotype(0x00ff, 0x00ff), genotype(0x00ff, 0xff00));
    let base = evaluate(&one, draw(0, 0));
    assert_eq!(base, evaluate(&one, draw(0, 0)));
    for other in [evaluate(&two, draw(0, 0)), evaluate(&one, draw(1, 0)), evaluate(&one, draw(0, 1))] {
        assert_ne!(base, other);
    }
    let other = Simulator::new(&experiment(2)).unwrap();
    assert_ne!(base, other.evaluate(&one, draw(0, 0), 0..16).unwrap());
    assert!(base.windows(2).all(|pair| pair[0] != pair[1]), "{base:?}");
    let sum = |gene| evaluate(&genotype(gene, gene), draw(0, 0)).iter().map(|o| o.score).sum::<f64>();
    assert!(sum(0x0001) < sum(0x00ff) && sum(0x00ff) < sum(0x7fff));
}

#[test]
fn what_does_not_fit_is_refused_and_nothing_can_be_looked_at() {
    let experiment = Experiment { engine: Engine::Null, ..Experiment::default() };
    let simulator = Simulator::new(&experiment).unwrap();
    let draw = Draw { replication: 0, generation: 0 };
    let short = Genotype::new([0_u16; 3]);
    assert!(matches!(simulator.evaluate(&short, draw, 0..1), Err(SimError::Genotype(_))));
    let good = Genotype::new(vec![0; simulator.gene_count()]);
    assert!(matches!(simulator.evaluate(&good, draw, 15..17), Err(SimError::Trial { trial: 16, .. })));
    let case = Case::Drawn { draw, trial: 0 };
    assert_eq!(simulator.trace(&good, case), Err(SimError::Engine(EngineError::Null)));
}
