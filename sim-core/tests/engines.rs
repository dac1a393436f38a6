//! Both engines simulate the same robot and the same scene.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::f64::consts::FRAC_PI_2;

mod overlap;

use nalgebra::{UnitQuaternion, Vector3};
use overlap::{Overlap, upright};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use selftalk_sim::behaviours::Starts;
use selftalk_sim::experiment::{Engine as Kind, Experiment};
use selftalk_sim::physics::{Engine, Instructions, Observation, Placement, engine};
use selftalk_sim::robot::{JOINTS, RobotModel, joint};
use selftalk_sim::scene;

type Angles = [f64; JOINTS];

/// Where the object is in nobody's way.
const AWAY: [f64; 3] = [2.0, 0.0, scene::OBJECT_STANDING];
const UPRIGHT: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

fn build(kind: Kind, substeps: u32) -> Box<dyn Engine> {
    let mut experiment = Experiment { engine: kind, ..Experiment::default() };
    experiment.physics.substeps = substeps;
    engine(&RobotModel::icub().unwrap(), &experiment, Instructions::Best).unwrap()
}

/// What an engine shows of a trial, control step by control step.
fn course(
    kind: Kind,
    substeps: u32,
    placement: &Placement,
    targets: &Angles,
    steps: u32,
) -> Vec<Observation> {
    let mut engine = build(kind, substeps);
    engine.place(0, placement);
    engine.command(0, targets);
    let advance = |_| {
        engine.advance();
        engine.observe(0)
    };
    (0..steps).map(advance).collect()
}

/// Largest difference of a joint's angles in two courses, in radians.
fn difference(a: &[Observation], b: &[Observation]) -> f64 {
    let angles = |course: &[Observation]| course.iter().flat_map(|seen| seen.angles).collect::<Vec<f64>>();
    angles(a).iter().zip(angles(b)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn random_angles(robot: &RobotModel, stream: &mut ChaCha8Rng) -> Angles {
    std::array::from_fn(|i| robot.joints[i].angle(stream.random::<f64>()))
}

#[test]
fn the_arm_follows_its_servos_alike_the_more_so_the_smaller_the_step() {
    let robot = RobotModel::icub().unwrap();
    let mut stream = ChaCha8Rng::seed_from_u64(1);
    let (mut coarse, mut fine) = (0.0_f64, 0.0_f64);
    let mut compared = 0;
    while compared < 4 {
        let (angles, targets) = (random_angles(&robot, &mut stream), random_angles(&robot, &mut stream));
        let placement = Placement { angles, targets: angles, object: AWAY, orientation: UPRIGHT };
        let run = |kind, substeps| course(kind, substeps, &placement, &targets, 16);
        let reference = run(Kind::Lockstep, 8);
        // On the table, who slips first is chance.
        if reference.iter().any(|seen| Overlap::of(&robot, seen).robot_table() > -0.1) {
            continue;
        }
        coarse = coarse.max(difference(&reference, &run(Kind::Rapier, 8)));
        fine = fine.max(difference(&run(Kind::Lockstep, 32), &run(Kind::Rapier, 32)));
        compared += 1;
    }
    assert!(coarse < 0.005, "{coarse} rad");
    assert!(fine < 0.35 * coarse, "{fine} rad of {coarse} rad");
}

#[test]
fn finger_joints_beyond_their_stops_come_back_alike() {
    let robot = RobotModel::icub().unwrap();
    for upper in [false, true] {
        let mut angles = Starts::shipped().unwrap().reach[0].angles;
        for (angle, joint) in angles.iter_mut().zip(&robot.joints).skip(joint::HAND + 1) {
            *angle = if upper { joint.upper + 0.02 } else { joint.lower - 0.02 };
        }
        let placement = Placement { angles, targets: angles, object: AWAY, orientation: UPRIGHT };
        let [a, b] = Kind::SIMULATED.map(|kind| course(kind, 32, &placement, &angles, 4));
        let beyond = |i: usize, angle: f64| angle - angle.clamp(robot.joints[i].lower, robot.joints[i].upper);
        assert!(a[0].angles.iter().enumerate().any(|(i, angle)| beyond(i, *angle).abs() > 0.001), "{a:?}");
        assert!(a[3].angles.iter().enumerate().all(|(i, angle)| beyond(i, *angle).abs() < 0.003), "{a:?}");
        assert!(difference(&a, &b) < 0.0005, "{} rad", difference(&a, &b));
    }
}

fn tilted(angle: f64) -> [f64; 4] {
    let q = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), angle);
    [q.w, q.i, q.j, q.k]
}

/// The object three seconds after it was placed on the table, far from the hand.
fn settled(kind: Kind, height: f64, orientation: [f64; 4]) -> Observation {
    let angles = Starts::shipped().unwrap().reach[0].angles;
    let object = [-0.3, -0.2, height];
    let placement = Placement { angles, targets: angles, object, orientation };
    course(kind, 8, &placement, &angles, 60).pop().unwrap()
}

#[test]
fn an_object_on_the_table_stays_where_it_stands() {
    for kind in Kind::SIMULATED {
        let seen = settled(kind, scene::OBJECT_STANDING, UPRIGHT);
        let moved = (Vector3::from(seen.object) - Vector3::new(-0.3, -0.2, scene::OBJECT_STANDING)).norm();
        assert!(moved < 0.0005, "{kind:?}: moved by {moved} m");
        assert!(upright(&seen) > 0.99999, "{kind:?}: {seen:?}");
    }
}

#[test]
fn a_tilted_object_falls_back_onto_its_base() {
    for kind in Kind::SIMULATED {
        let seen = settled(kind, scene::TABLE + scene::OBJECT_RADIUS, tilted(0.3));
        assert!(upright(&seen) > 0.9999, "{kind:?}: {seen:?}");
        assert!((seen.object[2] - scene::OBJECT_STANDING).abs() < 0.0005, "{kind:?}: {seen:?}");
    }
}

#[test]
fn an_object_on_its_side_lies_on_its_round_part() {
    for kind in Kind::SIMULATED {
        let seen = settled(kind, scene::TABLE + scene::OBJECT_RADIUS, tilted(FRAC_PI_2));
        assert!(upright(&seen).abs() < 0.1, "{kind:?}: {seen:?}");
        assert!((seen.object[2] - scene::TABLE - scene::OBJECT_RADIUS).abs() < 0.0005, "{kind:?}: {seen:?}");
    }
}
