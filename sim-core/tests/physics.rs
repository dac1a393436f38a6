//! The contacts against geometry: shapes stay apart, and nothing runs away, whatever is commanded.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod overlap;

use std::sync::Arc;

use overlap::Overlap;
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use selftalk_sim::behaviours::{Start, Starts};
use selftalk_sim::experiment::Task;
use selftalk_sim::physics::{Engine, Instructions, engine};
use selftalk_sim::robot::{JOINTS, RobotModel};
use selftalk_sim::{Behaviour, Case, Draw, Experiment, Genotype, Job, Simulator, scene};

/// Control steps in a second.
const SECOND: usize = 20;

type Angles = [f64; JOINTS];

/// The start of trial `i` of 16, with the object in the middle of its area.
fn place(engine: &mut dyn Engine, lane: usize, i: usize) {
    let starts = Starts::shipped().unwrap();
    let start: &Start = &starts.of(Behaviour::of_trial(Task::Elementary, i as u32))[i % 4];
    let [x, y] = scene::AREA_DIRECTIONS[i % 4];
    let [middle_x, middle_y] = scene::AREAS_CENTRE;
    let object = [middle_x + x * scene::AREAS_DISTANCE, middle_y + y * scene::AREAS_DISTANCE];
    engine.place(lane, &start.placement(object));
}

fn lockstep(robot: &RobotModel) -> Box<dyn Engine> {
    engine(robot, &Experiment::default(), Instructions::Best).unwrap()
}

/// Commands all over the joints' ranges, or only at their ends: there the servos push with all their torque.
fn commands(stream: &mut ChaCha8Rng, robot: &RobotModel) -> Angles {
    let extreme = stream.random::<bool>();
    std::array::from_fn(|i| {
        let share = stream.random::<f64>();
        robot.joints[i].angle(if extreme { share.round() } else { share })
    })
}

#[test]
fn shapes_are_apart_at_the_start_of_every_trial() {
    let robot = RobotModel::icub().unwrap();
    let mut engine = lockstep(&robot);
    for trial in 0..16 {
        place(engine.as_mut(), 0, trial);
        let overlap = Overlap::of(&robot, &engine.observe(0));
        assert!(overlap.worst() < 0.0005, "trial {trial}: {overlap:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Hand and object are pushed against table and each other with all the torque the servos have, for 4 s. While they
    /// still hit each other, in the first two, they may overlap more.
    #[test]
    fn full_torque_presses_nothing_a_millimetre_deep(seed in any::<u64>()) {
        let robot = RobotModel::icub().unwrap();
        let mut stream = ChaCha8Rng::seed_from_u64(seed);
        let mut engine = lockstep(&robot);
        for trial in 0..16 {
            let lane = trial % engine.lanes();
            place(engine.as_mut(), lane, trial);
            engine.command(lane, &commands(&mut stream, &robot));
            if lane + 1 < engine.lanes() && trial < 15 {
                continue;
            }
            for step in 0..4 * SECOND {
                engine.advance();
                for lane in 0..=lane {
                    let overlap = Overlap::of(&robot, &engine.observe(lane));
                    let bound = if step < 2 * SECOND { 0.005 } else { 0.001 };
                    prop_assert!(overlap.worst() < bound, "lane {lane}, step {step}: {overlap:?}");
                }
            }
        }
    }
}

/// Every lane gets other commands every 0.2 s, so that the hand slams into things and flings the object about.
#[test]
fn erratic_commands_press_something_a_millimetre_deep_in_less_than_one_of_5000_control_steps() {
    let robot = RobotModel::icub().unwrap();
    let mut stream = ChaCha8Rng::seed_from_u64(1);
    let mut engine = lockstep(&robot);
    let (mut steps, mut deep) = (0, 0);
    for episode in 0..400 {
        for lane in 0..engine.lanes() {
            place(engine.as_mut(), lane, (episode + lane) % 16);
        }
        for step in 0..2 * SECOND {
            for lane in 0..engine.lanes() {
                if step % 4 == 0 {
                    engine.command(lane, &commands(&mut stream, &robot));
                }
            }
            engine.advance();
            for lane in 0..engine.lanes() {
                let overlap = Overlap::of(&robot, &engine.observe(lane));
                assert!(overlap.worst() < 0.005, "episode {episode}, lane {lane}, step {step}: {overlap:?}");
                steps += 1;
                deep += u32::from(overlap.worst() > 0.001);
            }
        }
    }
    assert!(deep * 5000 < steps, "{deep} of {steps} control steps");
}

/// Weights of up to 1000, a third of them at the very ends, drive every motor from one end to the other at any step.
#[test]
fn ten_thousand_extreme_controllers_keep_the_simulation_finite() {
    let overrides = ["controller.weight_range=1000.0".to_owned()];
    let experiment = Experiment::from_toml("test", "", &overrides).unwrap();
    let simulator = Simulator::new(&experiment).unwrap();
    let mut stream = ChaCha8Rng::seed_from_u64(2);
    let mut jobs = (0..10_000_u32).map(|i| {
        let genes = (0..simulator.gene_count()).map(|_| match stream.random_range(0..6_u8) {
            0 => 0,
            1 => u16::MAX,
            _ => stream.random::<u16>(),
        });
        let genotype = Arc::new(Genotype::new(genes.collect::<Vec<u16>>()));
        let (draw, trial) = (Draw { replication: 0, generation: i }, i % 16);
        Job { genotype, case: Case::Drawn { draw, trial }, tag: trial }
    });
    let mut done = 0;
    let finished = |trial, outcome: selftalk_sim::TrialOutcome| {
        // A simulation that leaves the finite numbers ends its trial early, without success.
        let length = Behaviour::of_trial(Task::Elementary, trial).steps(&experiment);
        assert!(outcome.success || outcome.steps == length, "trial {trial}: {outcome:?}");
        done += 1;
    };
    simulator.run(|| jobs.next(), finished).unwrap();
    assert_eq!(done, 10_000);
}
