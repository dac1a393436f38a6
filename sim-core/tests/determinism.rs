//! The same bits whatever the engine's instruction set, the lane, the neighbours and what a lane ran before.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::sync::Arc;

use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use selftalk_sim::behaviours::{Condition, Starts};
use selftalk_sim::experiment::{Engine as Kind, Preset};
use selftalk_sim::physics::{Instructions, engine};
use selftalk_sim::robot::{JOINTS, RobotModel};
use selftalk_sim::{Behaviour, Case, Draw, Experiment, Genotype, Job, Simulator, TrialOutcome};
use sha2::{Digest, Sha256};

const DRAW: Draw = Draw { replication: 1, generation: 2 };

const fn case(trial: u32) -> Case {
    Case::Drawn { draw: DRAW, trial }
}

fn genotype(simulator: &Simulator, seed: u64) -> Genotype {
    let mut stream = ChaCha8Rng::seed_from_u64(seed);
    Genotype::new((0..simulator.gene_count()).map(|_| stream.random()).collect::<Vec<u16>>())
}

fn hex(hash: Sha256) -> String {
    hash.finalize().iter().take(8).map(|byte| format!("{byte:02x}")).collect()
}

/// An experiment in the other engine, with trials of some control steps, as that engine is slow.
fn brief(steps: u32) -> Experiment {
    let mut experiment = Experiment { engine: Kind::Rapier, ..Experiment::default() };
    let Experiment { reach, open, grasp, transport, .. } = &mut experiment;
    for length in [&mut reach.steps, &mut open.steps, &mut grasp.steps, &mut transport.steps] {
        *length = steps;
    }
    experiment
}

fn outcomes_digest(experiment: &Experiment, instructions: Instructions, genotypes: u64) -> String {
    let simulator = Simulator::with_instructions(experiment, instructions).unwrap();
    let mut hash = Sha256::new();
    for seed in 0..genotypes {
        for outcome in simulator.evaluate(&genotype(&simulator, seed), DRAW, 0..16).unwrap() {
            hash.update(outcome.score.to_bits().to_le_bytes());
            hash.update([u8::from(outcome.success)]);
            hash.update(outcome.steps.to_le_bytes());
        }
    }
    hex(hash)
}

/// All signals of a trial of each behaviour.
fn signals_digest(experiment: &Experiment, instructions: Instructions) -> String {
    let simulator = Simulator::with_instructions(experiment, instructions).unwrap();
    let mut hash = Sha256::new();
    for trial in [0, 5, 10, 15] {
        for frame in simulator.trace(&genotype(&simulator, 7), case(trial)).unwrap().frames {
            let seen = &frame.observation;
            let signals = frame
                .sensors
                .iter()
                .chain(&frame.activity.internal)
                .chain(&frame.motors.0)
                .chain(&seen.angles)
                .chain(&seen.palm)
                .chain(&seen.object)
                .chain(&seen.orientation);
            for signal in signals {
                hash.update(signal.to_bits().to_le_bytes());
            }
        }
    }
    hex(hash)
}

/// The shipped grasps under commands that wave the arm and clench the hand: rich in contacts.
fn states_digest(experiment: &Experiment, instructions: Instructions, steps: u32) -> String {
    let robot = RobotModel::icub().unwrap();
    let mut engine = engine(&robot, experiment, instructions).unwrap();
    let starts = Starts::shipped().unwrap();
    let mut hash = Sha256::new();
    for behaviour in Behaviour::ELEMENTARY {
        for (i, start) in starts.of(behaviour).iter().enumerate() {
            let lane = i % engine.lanes();
            engine.place(lane, &start.placement([-0.3, -0.1]));
            let mut stream = ChaCha8Rng::seed_from_u64(i as u64);
            for _ in 0..steps {
                let targets: [f64; JOINTS] =
                    std::array::from_fn(|i| robot.joints[i].angle(stream.random::<f64>()));
                engine.command(lane, &targets);
                engine.advance();
                let seen = engine.observe(lane);
                for number in seen.angles.iter().chain(&seen.object).chain(&seen.orientation) {
                    hash.update(number.to_bits().to_le_bytes());
                }
            }
        }
    }
    hex(hash)
}

/// Digests of outcomes, signals and states. They change only with the simulator, and then its users' histories do; the first
/// two also with the defaults of an experiment.
const GOLDEN: [&str; 3] = ["63682335ebd87fc7", "c3b3483f3e40aebc", "b2fe46f18a71a9b5"];

#[test]
fn all_instruction_sets_give_the_golden_digests() {
    let experiment = Experiment::default();
    for instructions in [Instructions::Best, Instructions::Avx2, Instructions::Baseline] {
        let digests = [
            outcomes_digest(&experiment, instructions, 4),
            signals_digest(&experiment, instructions),
            states_digest(&experiment, instructions, 10),
        ];
        assert_eq!(digests, GOLDEN, "{instructions:?}");
    }
}

/// The digest of outcomes with lead-ins and grips that have to hold, which the fingerprint does not cover: when it
/// changes, but for another setting of the preset, the fingerprint has to change as well.
const GOLDEN_LINKED: &str = "83bba3e878858237";

fn linked() -> Experiment {
    Preset::find("elementary-linked").unwrap().experiment(&[]).unwrap()
}

#[test]
fn actions_that_follow_on_from_each_other_give_the_golden_digest() {
    for instructions in [Instructions::Best, Instructions::Avx2, Instructions::Baseline] {
        assert_eq!(outcomes_digest(&linked(), instructions, 4), GOLDEN_LINKED, "{instructions:?}");
    }
}

#[test]
fn a_lead_in_is_not_judged_and_decides_where_the_trial_begins() {
    let mut experiment = Experiment::default();
    experiment.trials.lead_in = 12;
    let [plain, linked] =
        [Experiment::default(), experiment].map(|experiment| Simulator::new(&experiment).unwrap());
    let genotype = genotype(&plain, 3);
    let traces = |trial| [&plain, &linked].map(|simulator| simulator.trace(&genotype, case(trial)).unwrap());
    let [without, with] = traces(0);
    assert_eq!(without, with, "nothing comes before REACH");
    let mut others = 0;
    for trial in 4..16 {
        let [without, with] = traces(trial);
        let label = Some(plain.behaviour(trial));
        assert!(with.frames.iter().all(|frame| frame.heard == label), "{trial}");
        assert_eq!((with.frames.len(), &with.start), (without.frames.len(), &without.start), "{trial}");
        others += u32::from(with.frames[0] != without.frames[0]);
    }
    assert!(others > 8, "{others} of 12: one in thirteen has no lead-in by chance");
}

/// The same of the rapier engine.
const GOLDEN_RAPIER: [&str; 3] = ["8a17bdeab8af5715", "0578866e7de4c65e", "e5731d8866da57ef"];

#[test]
fn the_rapier_engine_gives_the_golden_digests() {
    let experiment = brief(8);
    let digests = [
        outcomes_digest(&experiment, Instructions::Best, 1),
        signals_digest(&experiment, Instructions::Best),
        states_digest(&experiment, Instructions::Best, 4),
    ];
    assert_eq!(digests, GOLDEN_RAPIER);
}

#[test]
fn a_trial_in_the_rapier_engine_does_not_depend_on_those_before_it() {
    let simulator = Simulator::new(&brief(3)).unwrap();
    let genotype = genotype(&simulator, 5);
    let together = simulator.evaluate(&genotype, DRAW, 6..16).unwrap();
    for (trial, outcome) in (6..).zip(together) {
        let alone = simulator.evaluate(&genotype, DRAW, trial..trial + 1).unwrap();
        assert_eq!(alone[0].score.to_bits(), outcome.score.to_bits(), "{trial}");
        assert_eq!(alone[0], outcome);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]

    #[test]
    fn a_trial_does_not_depend_on_its_neighbours(
        seeds in prop::collection::vec(0..1000_u64, 1..5),
        order in prop::collection::vec((any::<prop::sample::Index>(), 0..16_u32), 1..12),
    ) {
        let simulator = Simulator::new(&Experiment::default()).unwrap();
        let genotypes: Vec<Arc<Genotype>> =
            seeds.iter().map(|seed| Arc::new(genotype(&simulator, *seed))).collect();
        let mut jobs = order.iter().map(|(index, trial)| {
            let genotype = index.get(&genotypes);
            let tag = (Arc::clone(genotype), *trial);
            Job { genotype: Arc::clone(genotype), case: case(*trial), tag }
        });
        let mut crowded: Vec<((Arc<Genotype>, u32), TrialOutcome)> = Vec::new();
        simulator.run(|| jobs.next(), |tag, outcome| crowded.push((tag, outcome))).unwrap();
        prop_assert_eq!(crowded.len(), order.len());
        for ((genotype, trial), outcome) in crowded {
            let alone = simulator.evaluate(&genotype, DRAW, trial..trial + 1).unwrap();
            prop_assert_eq!(alone[0].score.to_bits(), outcome.score.to_bits());
            prop_assert_eq!(alone[0], outcome);
        }
    }

    #[test]
    fn a_trace_comes_to_the_same_as_its_trial(seed in 0..1000_u64, trial in 0..16_u32, lead in any::<bool>()) {
        let simulator = Simulator::new(&if lead { linked() } else { Experiment::default() }).unwrap();
        let genotype = genotype(&simulator, seed);
        let trace = simulator.trace(&genotype, case(trial)).unwrap();
        prop_assert_eq!(trace.frames.len() as u32, trace.outcome.steps);
        prop_assert_eq!(vec![trace.outcome], simulator.evaluate(&genotype, DRAW, trial..trial + 1).unwrap());
        for frame in trace.frames {
            prop_assert!(!frame.conditions.is_empty());
            prop_assert_eq!(frame.goal, frame.conditions.iter().all(Condition::holds));
        }
    }

    /// Weights of up to 1000 drive every motor from one end to the other at any step.
    #[test]
    fn no_controller_drives_the_simulation_out_of_bounds(seed in 0..1_000_000_u64, trial in 0..16_u32) {
        let overrides = ["controller.weight_range=1000.0".to_owned()];
        let experiment = Experiment::from_toml("test", "", &overrides).unwrap();
        let simulator = Simulator::new(&experiment).unwrap();
        let trace = simulator.trace(&genotype(&simulator, seed), case(trial)).unwrap();
        for frame in trace.frames {
            prop_assert!(frame.observation.is_finite());
            prop_assert!(frame.observation.palm.iter().all(|x| x.abs() < 1.0), "{:?}", frame.observation);
            prop_assert!(frame.observation.object.iter().all(|x| x.abs() < 20.0), "{:?}", frame.observation);
        }
        prop_assert!((0.0..=1.0).contains(&trace.outcome.score));
    }
}

#[test]
fn evaluations_that_do_not_fit_are_refused() {
    let simulator = Simulator::new(&Experiment::default()).unwrap();
    assert!(simulator.evaluate(&Genotype::new([0_u16; 10]), DRAW, 0..1).is_err());
    assert!(simulator.evaluate(&genotype(&simulator, 1), DRAW, 16..17).is_err());
}
