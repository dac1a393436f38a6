//! Where things come to rest: the object on the table and in the hand, and the hand on the table.
//!
//! MuJoCo's contacts are soft where ours are hard, so scenes are compared where they end. Friction holds a thing in a
//! whole range of places, and where in it the thing stops depends on how it got there: the scenes avoid sudden slips,
//! after which nothing brings two simulators together again.

use nalgebra::{Isometry3, Quaternion, UnitQuaternion};
use serde::{Deserialize, Serialize};

use super::python::Python;
use super::*;
use crate::behaviours::{Start, Starts};
use crate::robot::{HandGoal, Part};

/// Control steps in a second.
const SECOND: usize = 20;

/// The shipped settings.
const SHIPPED: fn() -> Physics = Physics::default;
/// Settings with which the sweeps leave next to nothing to solve.
const SOLVED: fn() -> Physics = || Physics { substeps: 32, sweeps: 100, ..Physics::default() };

/// Robot and object at rest, and the servos' targets in each of the following control steps.
#[derive(Serialize)]
struct Scene {
    angles: [f64; JOINTS],
    object: [f64; 3],
    orientation: [f64; 4],
    friction: f64,
    commands: Vec<[f64; JOINTS]>,
}

/// How a scene ends.
#[derive(Deserialize)]
struct Rest {
    angles: [f64; JOINTS],
    object: [f64; 3],
    orientation: [f64; 4],
}

impl Scene {
    /// The targets go to a share of their way within some seconds and stay there for some more.
    fn new(placement: &Placement, share: f64, ramp: usize, hold: usize) -> Self {
        let &Placement { angles, targets, object, orientation } = placement;
        let steps = (ramp * SECOND).max(1);
        let at = |step: usize| {
            let share = share * step.min(steps) as f64 / steps as f64;
            std::array::from_fn(|i| angles[i] + share * (targets[i] - angles[i]))
        };
        let commands = (1..=steps + hold * SECOND).map(at).collect();
        Self { angles, object, orientation, friction: 1.0, commands }
    }

    fn ended(&self, physics: &Physics) -> Rest {
        let robot = RobotModel::icub().unwrap();
        let physics = Physics { friction: self.friction, ..physics.clone() };
        let mut engine = engine(&robot, &physics, Instructions::Best).unwrap();
        let &Self { angles, object, orientation, .. } = self;
        engine.place(LANE, &Placement { angles, targets: angles, object, orientation });
        for targets in &self.commands {
            engine.command(LANE, targets);
            engine.advance();
        }
        let Observation { angles, object, orientation, .. } = engine.observe(LANE);
        Rest { angles, object, orientation }
    }
}

/// Where the parts of a scene are.
struct Parts {
    object: Isometry3<f64>,
    in_hand: Isometry3<f64>,
    /// Palm and fingertips.
    points: Vec<Point3<f64>>,
}

impl Rest {
    fn parts(&self, robot: &RobotModel) -> Parts {
        let links = Kinematics::new(robot, &self.angles).links;
        let [w, x, y, z] = self.orientation;
        let turn = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
        let object = Isometry3::from_parts(self.object.into(), turn);
        let tip = |finger| {
            let capsule = robot.capsule(Part::Fingertip(finger)).unwrap();
            links[capsule.link] * capsule.end
        };
        let points = [links[joint::HAND] * robot.palm.point()].into_iter().chain((0..5).map(tip)).collect();
        Parts { object, in_hand: links[joint::HAND].inverse() * object, points }
    }
}

/// Where the object is looked for.
#[derive(Clone, Copy, PartialEq)]
enum Seen {
    InRoom,
    InHand,
    Not,
}

/// Compares how scenes end; lengths are bounded in millimetres, angles in degrees.
fn compare(what: &str, scenes: &[Scene], physics: &Physics, seen: Seen, millimetres: f64, degrees: f64) {
    let robot = RobotModel::icub().unwrap();
    let mut object = Bound::new(format!("{what}: object, mm"), millimetres);
    let mut turn = Bound::new(format!("{what}: object, degrees"), degrees);
    let mut points = Bound::new(format!("{what}: palm and fingertips, mm"), millimetres);
    let mut angles = Bound::new(format!("{what}: joints, degrees"), degrees);
    let theirs: Vec<Rest> = Python::start().ask("rest", &scenes);
    assert_eq!(theirs.len(), scenes.len());
    for (scene, theirs) in scenes.iter().zip(&theirs) {
        let ours = scene.ended(physics);
        let (a, b) = (ours.parts(&robot), theirs.parts(&robot));
        let at = |parts: &Parts| if seen == Seen::InHand { parts.in_hand } else { parts.object };
        let apart = at(&a).inverse() * at(&b);
        object.take(apart.translation.vector.norm() * 1e3);
        turn.take(apart.rotation.angle().to_degrees());
        for (a, b) in a.points.iter().zip(&b.points) {
            points.take((a - b).norm() * 1e3);
        }
        for (a, b) in ours.angles.iter().zip(&theirs.angles) {
            angles.take((a - b).abs().to_degrees());
        }
    }
    if seen != Seen::Not {
        object.hold();
        turn.hold();
    }
    points.hold();
    angles.hold();
}

/// The shipped postures with the object in the hand, and the same grips with the palm turned up.
fn held() -> Vec<Scene> {
    let palm_up = [0.2, 0.05, -1.26, 1.47, -0.5, 1.81, 0.45, -1.28, 0.36];
    let robot = RobotModel::icub().unwrap();
    let starts = Starts::shipped().unwrap().held;
    let shipped = starts.map(|start| start.placement([0.0; 2]));
    let turned = shipped.clone().map(|mut placement| {
        let hand = |angles: &[f64; JOINTS]| Kinematics::new(&robot, angles).links[joint::HAND];
        let before = hand(&placement.angles);
        for angles in [&mut placement.angles, &mut placement.targets] {
            angles[joint::CARRIER].copy_from_slice(&palm_up);
        }
        let moved = hand(&placement.angles) * before.inverse();
        placement.object = (moved * Point3::from(placement.object)).coords.into();
        placement
    });
    shipped.iter().chain(&turned).map(|placement| Scene::new(placement, 1.0, 0, 3)).collect()
}

/// The open hand over the table, driven downwards until the palm would lie in the table's surface.
fn pressing(share: f64, ramp: usize, friction: f64) -> Vec<Scene> {
    let robot = RobotModel::icub().unwrap();
    let point = robot.palm.point();
    let press = |start: &Start| {
        let mut placement = start.placement([-0.5, 0.3]);
        let mut position = Kinematics::new(&robot, &placement.angles).links[joint::HAND] * point;
        position.z = scene::TABLE;
        let mut slopes: Vec<(i32, i32)> = (-8..=8).flat_map(|a| (-8..=8).map(move |b| (a, b))).collect();
        slopes.sort_by_key(|(a, b)| a * a + b * b);
        let reach = |(a, b)| {
            let (tilt, roll) = (0.1 * f64::from(a), 0.1 * f64::from(b));
            robot.bring_hand(&HandGoal { point, position, tilt, roll }, &placement.angles)
        };
        placement.targets = slopes.into_iter().find_map(reach).unwrap();
        Scene { friction, ..Scene::new(&placement, share, ramp, 3) }
    };
    Starts::shipped().unwrap().grasp.iter().map(press).collect()
}

#[test]
#[ignore = "asks MuJoCo: run `just referee`"]
fn an_object_dropped_on_its_base_comes_to_rest_where_mujocos_does() {
    let start = &Starts::shipped().unwrap().reach[0];
    let drop = |(tilt, heading): (f64, f64)| {
        let mut placement = start.placement([-0.3, -0.1]);
        placement.object[2] += 0.003;
        let axis = Vector3::new(libm::cos(heading), libm::sin(heading), 0.0);
        let turn = UnitQuaternion::new(axis * tilt);
        placement.orientation = [turn.w, turn.i, turn.j, turn.k];
        Scene::new(&placement, 1.0, 0, 2)
    };
    let scenes = [(0.0, 0.0), (0.01, 0.0), (0.03, 0.0), (0.05, 1.0), (0.1, 2.0), (0.1, 0.8)].map(drop);
    compare("dropped", &scenes, &SHIPPED(), Seen::InRoom, 1.0, 1.0);
}

#[test]
#[ignore = "asks MuJoCo: run `just referee`"]
fn a_held_object_rests_in_the_hand_as_mujocos_does() {
    // The fingers' contacts are near the edge of their cones, where a little more yielding turns a joint by a degree.
    compare("held", &held(), &SHIPPED(), Seen::InHand, 1.0, 1.5);
    compare("held, solved", &held(), &SOLVED(), Seen::InHand, 1.0, 1.0);
}

#[test]
#[ignore = "asks MuJoCo: run `just referee`"]
fn a_hand_pressed_on_a_smooth_table_yields_as_mujocos_does() {
    compare("pressed at once, smooth", &pressing(1.0, 0, 0.0), &SHIPPED(), Seen::Not, 1.0, 1.0);
    compare("pressed slowly, smooth", &pressing(1.0, 3, 0.0), &SHIPPED(), Seen::Not, 1.0, 1.0);
}

#[test]
#[ignore = "asks MuJoCo: run `just referee`"]
fn a_hand_that_sticks_to_the_table_yields_as_mujocos_does() {
    // A little further down some fingers slip.
    compare("pressed, sticking", &pressing(0.5, 3, 1.0), &SHIPPED(), Seen::Not, 1.0, 1.0);
}

#[test]
#[ignore = "asks MuJoCo: run `just referee`"]
fn a_hand_that_slides_on_the_table_stops_where_mujocos_does() {
    compare("pressed, sliding", &pressing(1.0, 3, 0.1), &SHIPPED(), Seen::Not, 1.0, 1.0);
}
