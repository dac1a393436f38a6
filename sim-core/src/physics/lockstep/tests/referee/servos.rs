//! How the servos bring the robot from one posture to another, with nothing to touch.

use serde::Serialize;

use super::python::Python;
use super::*;

/// Servos that drive the robot from rest at one posture to another.
#[derive(Serialize)]
struct Case {
    integrator: &'static str,
    step: f64,
    start: [f64; JOINTS],
    targets: [f64; JOINTS],
    seconds: f64,
}

/// Angles after every control step.
type Course = Vec<[f64; JOINTS]>;

fn course<S: Simd>(simd: S, tree: &Tree, case: &Case) -> Course {
    let mut joints = Joints {
        angles: spread(simd, &case.start),
        velocities: [splat(simd, 0.0); JOINTS],
        targets: spread(simd, &case.targets),
    };
    let mut factor = Factor::new(simd);
    let steps = |seconds: f64, step: f64| (seconds / step).round() as u32;
    (0..steps(case.seconds, CONTROL_STEP))
        .map(|_| {
            for _ in 0..steps(CONTROL_STEP, case.step) {
                let poses = poses(simd, tree, &joints.angles);
                let mut whitened = [splat(simd, 0.0); JOINTS];
                dynamics::smooth(simd, tree, &poses, &joints, case.step, &mut factor, &mut whitened);
                dynamics::recover(simd, tree, &mut factor, &whitened, &mut joints.velocities);
                for (angle, velocity) in joints.angles.iter_mut().zip(&joints.velocities) {
                    *angle += *velocity * case.step;
                }
            }
            std::array::from_fn(|i| joints.angles[i][LANE])
        })
        .collect()
}

/// The largest difference between two courses, rad.
fn apart(ours: &Course, theirs: &Course) -> f64 {
    assert_eq!(ours.len(), theirs.len());
    let pairs = ours.iter().flatten().zip(theirs.iter().flatten());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Compares random motions; the bound is in radians. MuJoCo takes `integrator` and `theirs` as its step.
fn compare(what: &str, integrator: &'static str, theirs: f64, ours: f64, bound: f64) {
    let mut random = Random::new(3);
    let tree = Tree::new(&random.robot).unwrap();
    let mut case = || Case {
        integrator,
        step: theirs,
        start: random.posture(),
        targets: random.posture(),
        seconds: 1.0,
    };
    let cases: Vec<Case> = (0..40).map(|_| case()).collect();
    let answer: Vec<Course> = Python::start().ask("responses", &cases);
    assert_eq!(answer.len(), cases.len());
    let mut bound = Bound::new(format!("{what}: joints over a second, rad"), bound);
    for (case, answer) in cases.into_iter().zip(&answer) {
        let case = Case { step: ours, ..case };
        bound.take(apart(&dispatch!(Level::new(), simd => course(simd, &tree, &case)), answer));
    }
    bound.hold();
}

/// The shipped length of a step.
fn shipped() -> f64 {
    CONTROL_STEP / f64::from(Physics::default().substeps)
}

#[test]
#[ignore = "asks MuJoCo: run `just referee`"]
fn servos_drive_the_robot_as_mujocos_do() {
    compare("steps of 0.25 ms", "IMPLICIT", 2.5e-4, 2.5e-4, 5e-4);
}

#[test]
#[ignore = "asks MuJoCo: run `just referee`"]
fn the_shipped_step_is_short_enough_for_the_servos() {
    compare("shipped step against 0.125 ms", "IMPLICIT", 1.25e-4, shipped(), 5e-3);
}

/// MuJoCo's integrator `discrete` takes stiffness and damping implicitly, as ours does.
#[test]
#[ignore = "asks MuJoCo: run `just referee`"]
fn the_shipped_step_does_what_mujocos_discrete_integrator_does() {
    compare("shipped step against the same", "DISCRETE", shipped(), shipped(), 2e-3);
}
