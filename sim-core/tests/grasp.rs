//! Scripted grasps through the public interface: nothing but contact forces holds the object.

#![expect(clippy::unwrap_used, clippy::expect_used, reason = "a test may panic")]

mod overlap;

use nalgebra::{Point3, Vector3};
use overlap::Overlap;
use selftalk_sim::behaviours::{Behaviour, Condition, Start, Starts, View};
use selftalk_sim::experiment::{Engine as Kind, Experiment};
use selftalk_sim::physics::{Engine, Instructions, Observation, engine};
use selftalk_sim::robot::{HandGoal, JOINTS, Kinematics, RobotModel, joint};
use selftalk_sim::{Case, Genotype, Simulator, scene};

type Angles = [f64; JOINTS];

/// Control steps in a second.
const SECOND: u32 = 20;

struct Scene {
    robot: RobotModel,
    engine: Box<dyn Engine>,
    commanded: Angles,
}

impl Scene {
    fn new(kind: Kind, start: &Start, object: [f64; 2], friction: f64) -> Self {
        let robot = RobotModel::icub().unwrap();
        let mut experiment = Experiment { engine: kind, ..Experiment::default() };
        experiment.physics.friction = friction;
        let mut engine = engine(&robot, &experiment, Instructions::Best).unwrap();
        let placement = start.placement(object);
        engine.place(0, &placement);
        Self { robot, engine, commanded: placement.targets }
    }

    /// Drives the servos' targets to new angles, evenly, in a time given in control steps.
    fn drive(&mut self, to: Angles, steps: u32) {
        let from = self.commanded;
        for step in 1..=steps {
            let share = f64::from(step) / f64::from(steps);
            self.commanded = std::array::from_fn(|i| from[i] + share * (to[i] - from[i]));
            self.engine.command(0, &self.commanded);
            self.engine.advance();
        }
    }

    /// Closes the fingers, with the thumb opposed to them as in the shipped grasps.
    fn close_fingers(&mut self) {
        let mut closed = self.commanded;
        let opposed = Starts::shipped().unwrap().held[0].placement([0.0; 2]).targets;
        closed[joint::THUMB_OPPOSITION] = opposed[joint::THUMB_OPPOSITION];
        for i in joint::FLEXION {
            closed[i] = self.robot.joints[i].angle(0.9);
        }
        self.drive(closed, 10);
        self.drive(closed, SECOND);
    }

    fn see(&self) -> Observation {
        self.engine.observe(0)
    }

    /// Where the object's centre is in the hand's frame.
    fn in_hand(&self) -> Point3<f64> {
        let seen = self.see();
        let hand = Kinematics::new(&self.robot, &seen.angles).links[joint::HAND];
        hand.inverse() * Point3::from(seen.object)
    }

    /// Servo targets that shift the hand, its slope changed as little as need be; the fingers stay as they are.
    fn shifted(&self, shift: [f64; 3]) -> Angles {
        let hand = Kinematics::new(&self.robot, &self.commanded).links[joint::HAND];
        let (tilt, roll) = (libm::asin((hand * -Vector3::x()).z), libm::asin((hand * Vector3::z()).z));
        let position = Point3::from(hand.translation.vector + Vector3::from(shift));
        let mut slopes: Vec<(i32, i32)> = (-6..=6).flat_map(|a| (-6..=6).map(move |b| (a, b))).collect();
        slopes.sort_by_key(|(a, b)| a * a + b * b);
        slopes
            .into_iter()
            .find_map(|(a, b)| {
                let (tilt, roll) = (tilt + 0.1 * f64::from(a), roll + 0.1 * f64::from(b));
                self.robot
                    .bring_hand(&HandGoal { point: Point3::origin(), position, tilt, roll }, &self.commanded)
            })
            .expect("the hand can be shifted")
    }
}

fn left_area() -> [f64; 2] {
    [scene::AREAS_CENTRE[0], scene::AREAS_CENTRE[1] - scene::AREAS_DISTANCE]
}

#[test]
fn a_grasped_object_is_lifted_moved_and_held() {
    for kind in Kind::SIMULATED {
        let starts = Starts::shipped().unwrap();
        // Where MOVE starts, the fingers feel the object.
        let mut scene = Scene::new(kind, &starts.transport[2], left_area(), 1.0);
        scene.close_fingers();
        assert!(scene.see().touch.iter().filter(|touch| **touch).count() >= 3, "{kind:?}: {:?}", scene.see());
        let standing = scene.see().object;
        let gripped = scene.in_hand();

        scene.drive(scene.shifted([0.0, 0.0, 0.13]), 3 * SECOND);
        let lifted = scene.see().object;
        assert!(lifted[2] - standing[2] > 0.10, "{kind:?}: lifted by {}", lifted[2] - standing[2]);

        scene.drive(scene.shifted([0.0, 0.21, 0.0]), 4 * SECOND);
        let hold = scene.commanded;
        scene.drive(hold, SECOND);
        let moved = scene.see().object;
        assert!(moved[1] - lifted[1] > 0.20, "{kind:?}: moved by {}", moved[1] - lifted[1]);

        let before = scene.in_hand();
        scene.drive(hold, 2 * SECOND);
        let slipped = (scene.in_hand() - before).norm();
        assert!(slipped < 0.001, "{kind:?}: slipped by {slipped} m in 2 s");
        let shifted = (scene.in_hand() - gripped).norm();
        assert!(shifted < 0.02, "{kind:?}: shifted in the hand by {shifted} m from grasp to end");
    }
}

#[test]
fn where_open_starts_it_is_enough_to_stretch_the_fingers() {
    let experiment = Experiment::default();
    for kind in Kind::SIMULATED {
        for (start, [x, y]) in Starts::shipped().unwrap().open.iter().zip(scene::AREA_DIRECTIONS) {
            let object = [
                scene::AREAS_CENTRE[0] + x * scene::AREAS_DISTANCE,
                scene::AREAS_CENTRE[1] + y * scene::AREAS_DISTANCE,
            ];
            let mut scene = Scene::new(kind, start, object, 1.0);
            let mut stretched = scene.commanded;
            for i in joint::FLEXION {
                stretched[i] = scene.robot.joints[i].angle(0.05);
            }
            scene.drive(stretched, 1);
            scene.drive(stretched, SECOND / 2);
            let view = View { robot: &scene.robot, observation: &scene.see(), target: [0.0; 3] };
            let conditions = Behaviour::Open.conditions(&experiment, &view);
            assert!(conditions.iter().all(Condition::holds), "{kind:?}: {conditions:?}");
        }
    }
}

#[test]
fn a_held_object_stays_held() {
    // A minute, or what takes about as long to simulate.
    for (kind, seconds) in [(Kind::Lockstep, 60), (Kind::Rapier, 4)] {
        for start in &Starts::shipped().unwrap().held {
            let mut scene = Scene::new(kind, start, [0.0; 2], 1.0);
            let hold = scene.commanded;
            scene.drive(hold, SECOND);
            let before = scene.in_hand();
            scene.drive(hold, seconds * SECOND);
            let slipped = (scene.in_hand() - before).norm();
            assert!(slipped < 0.005, "{kind:?}: slipped by {slipped} m");
            let overlap = Overlap::of(&scene.robot, &scene.see()).robot_object;
            assert!((-0.0005..0.001).contains(&overlap), "{kind:?}: {overlap} m into the hand");
        }
    }
}

#[test]
fn without_friction_the_object_stays_behind() {
    for kind in Kind::SIMULATED {
        for start in &Starts::shipped().unwrap().held {
            let mut held = Scene::new(kind, start, [0.0; 2], 1.0);
            let mut dropped = Scene::new(kind, start, [0.0; 2], 0.0);
            for scene in [&mut held, &mut dropped] {
                let hold = scene.commanded;
                scene.drive(hold, 3 * SECOND);
            }
            let height = |scene: &Scene| scene.see().object[2] - scene::OBJECT_STANDING;
            assert!(height(&held) > 0.05, "{kind:?}: {}", height(&held));
            assert!(height(&dropped) < 0.05, "{kind:?}: {}", height(&dropped));
        }
    }
}

#[test]
fn move_to_target_begins_clear_of_the_object_wherever_it_is() {
    let overrides = ["task=move-to-target", "move_to_target.steps=3"].map(str::to_owned);
    let experiment = Experiment::from_toml("test", "", &overrides).unwrap();
    let simulator = Simulator::new(&experiment).unwrap();
    let genotype = Genotype::new(vec![0x8000; simulator.gene_count()]);
    for number in 0..Case::GRID_TRIALS {
        let trace = simulator.trace(&genotype, Case::Grid { number }).unwrap();
        let seen = &trace.frames[0].observation;
        let moved: f64 =
            (0..3).map(|axis| (seen.object[axis] - trace.start.object[axis]).abs()).fold(0.0, f64::max);
        assert!(
            seen.touch.iter().all(|touch| !touch) && moved < 1e-3,
            "case {number}: {moved} {:?}",
            seen.touch
        );
    }
}
