//! The lockstep engine: trials side by side, one a vector lane, through the dynamics of this one robot.
//!
//! A step: where the links are ([`kinematics`]), how they would move without contacts ([`dynamics`]), which contacts
//! are close ([`contact`]), the impulses that resolve them ([`solver`]), and the new positions (semi-implicit Euler).

mod block;
mod contact;
mod dynamics;
mod kinematics;
mod lanes;
mod object;
mod solver;
mod spatial;
mod tree;

use fearless_simd::{Level, Simd, dispatch};
use nalgebra::Vector3;

use self::block::{Bodies, Velocities};
use self::contact::{CANDIDATES, Contact, FIRST_TOUCH, Movement};
use self::dynamics::{Factor, Joints};
use self::kinematics::Pose;
use self::lanes::{Real, lanes, splat};
use self::object::Object;
use self::solver::{Settings, Solver};
use self::spatial::{Rotation, Vec3};
use self::tree::Tree;
use super::{CONTROL_STEP, Engine, Observation, Placement, TOUCH_SENSORS};
use crate::experiment::Physics;
use crate::robot::{JOINTS, RobotError, RobotModel, joint};
use crate::scene;

/// Which instruction set the lanes use. All give the same bits; they differ in speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Instructions {
    /// The best of the machine's.
    #[default]
    Best,
    /// At most AVX2.
    Avx2,
    /// What every machine has.
    Baseline,
}

pub(super) fn engine(
    robot: &RobotModel,
    physics: &Physics,
    instructions: Instructions,
) -> Result<Box<dyn Engine>, RobotError> {
    let tree = Tree::new(robot)?;
    let palm = Landmarks::new(robot, &tree);
    let level = match instructions {
        Instructions::Best => Level::new(),
        Instructions::Avx2 => Level::new().as_avx2().map_or_else(Level::baseline, Level::Avx2),
        Instructions::Baseline => Level::baseline(),
    };
    Ok(dispatch!(level, simd => Box::new(Lockstep::new(simd, tree, palm, physics)) as Box<dyn Engine>))
}

/// Points that are observed, in the frames of the tree's links.
struct Landmarks {
    palm: Vector3<f64>,
    palm_normal: Vector3<f64>,
}

impl Landmarks {
    fn new(robot: &RobotModel, tree: &Tree) -> Self {
        // The tree's hand frame is turned; the palm's pose in it leads there.
        let turn =
            tree.shapes.palm_rotation * robot.palm.pose.rotation.to_rotation_matrix().matrix().transpose();
        Self { palm: turn * robot.palm.point().coords, palm_normal: turn * robot.palm.normal() }
    }
}

struct Lockstep<S: Simd> {
    simd: S,
    tree: Tree,
    landmarks: Landmarks,
    substeps: u32,
    settings: Settings,
    joints: Joints<S>,
    object: Object<S>,
    poses: [Pose<S>; JOINTS],
    factor: Factor<S>,
    contacts: Vec<Contact<S>>,
    solver: Solver<S>,
}

impl<S: Simd> Lockstep<S> {
    fn new(simd: S, tree: Tree, landmarks: Landmarks, physics: &Physics) -> Self {
        let zeros = [splat(simd, 0.0); JOINTS];
        let origin = Pose {
            rotation: Rotation::splat(simd, &nalgebra::Matrix3::identity()),
            position: Vec3::zero(simd),
        };
        let mut engine = Self {
            simd,
            tree,
            landmarks,
            substeps: physics.substeps,
            settings: Settings {
                step: CONTROL_STEP / f64::from(physics.substeps),
                sweeps: physics.sweeps,
                friction: physics.friction,
            },
            joints: Joints { angles: zeros, velocities: zeros, targets: zeros },
            object: Object::new(simd),
            poses: [origin; JOINTS],
            factor: Factor::new(simd),
            contacts: Vec::with_capacity(CANDIDATES),
            solver: Solver::new(simd),
        };
        // Lanes without a trial stand still, away from everything.
        for lane in 0..lanes::<S>() {
            engine.object.centre.z[lane] = 1e3;
        }
        kinematics::forward(simd, &engine.tree, &engine.joints.angles, &mut engine.poses);
        engine
    }

    fn step(&mut self) {
        let simd = self.simd;
        let step = self.settings.step;
        let mut whitened = [splat(simd, 0.0); JOINTS];
        dynamics::smooth(simd, &self.tree, &self.poses, &self.joints, step, &mut self.factor, &mut whitened);
        dynamics::recover(simd, &self.tree, &mut self.factor, &whitened, &mut self.joints.velocities);
        self.object.twist.linear.z -= scene::GRAVITY * step;
        let Self { tree, poses, factor, object, contacts, solver, settings, .. } = self;
        let movement = Movement { poses, velocities: &factor.velocities, object, step };
        contact::find(simd, &tree.shapes, &movement, contacts);
        solver.prepare(simd, &Bodies { tree, factor, object }, contacts, settings);
        let mut velocities = Velocities { robot: whitened, object: object.twist };
        solver.solve(simd, settings, &mut velocities);
        object.twist = velocities.object;
        // Where nothing touches the robot, its velocities are those from before.
        if contacts.iter().any(|contact| contact.link.is_some()) {
            dynamics::recover(simd, tree, factor, &velocities.robot, &mut self.joints.velocities);
        }
        self.drift();
        kinematics::forward(simd, &self.tree, &self.joints.angles, &mut self.poses);
    }

    fn drift(&mut self) {
        let simd = self.simd;
        let step = self.settings.step;
        simd.vectorize(
            #[inline(always)]
            || {
                for (angle, velocity) in self.joints.angles.iter_mut().zip(&self.joints.velocities) {
                    *angle += *velocity * step;
                }
                self.object.drift(simd, step);
            },
        );
    }
}

impl<S: Simd> Engine for Lockstep<S> {
    fn lanes(&self) -> usize {
        lanes::<S>()
    }

    fn place(&mut self, lane: usize, placement: &Placement) {
        let zero = [0.0; 3];
        for i in 0..JOINTS {
            self.joints.angles[i][lane] = placement.angles[i];
            self.joints.velocities[i][lane] = 0.0;
        }
        self.command(lane, &placement.targets);
        set(&mut self.object.centre, lane, placement.object);
        set(&mut self.object.twist.linear, lane, zero);
        set(&mut self.object.twist.angular, lane, zero);
        for (part, value) in self.object.orientation.iter_mut().zip(placement.orientation) {
            part[lane] = value;
        }
        self.solver.forget(lane);
        kinematics::forward(self.simd, &self.tree, &self.joints.angles, &mut self.poses);
    }

    fn command(&mut self, lane: usize, targets: &[f64; JOINTS]) {
        for ((target, value), link) in self.joints.targets.iter_mut().zip(targets).zip(&self.tree.links) {
            target[lane] = value.clamp(link.servo.lower, link.servo.upper);
        }
    }

    fn advance(&mut self) {
        for _ in 0..self.substeps {
            self.step();
        }
    }

    fn observe(&self, lane: usize) -> Observation {
        let simd = self.simd;
        let hand = &self.poses[joint::HAND];
        let tip = |finger: usize| {
            let capsule = &self.tree.shapes.capsules[finger];
            get(&self.poses[capsule.link].point(&capsule.end()), lane)
        };
        let mut touch = [false; TOUCH_SENSORS];
        for (candidate, touch) in (FIRST_TOUCH..).zip(&mut touch) {
            *touch = self.solver.impulse(candidate).normal[lane] > 0.0;
        }
        simd.vectorize(
            #[inline(always)]
            || Observation {
                angles: std::array::from_fn(|i| number::<S>(&self.joints.angles[i], lane)),
                palm: get(&hand.point(&self.landmarks.palm), lane),
                palm_normal: get(&hand.rotation.turn(&self.landmarks.palm_normal), lane),
                thumb_tip: tip(0),
                little_tip: tip(4),
                object: get(&self.object.centre, lane),
                orientation: std::array::from_fn(|i| number::<S>(&self.object.orientation[i], lane)),
                touch,
            },
        )
    }
}

fn set<S: Simd>(vector: &mut Vec3<S>, lane: usize, [x, y, z]: [f64; 3]) {
    vector.x[lane] = x;
    vector.y[lane] = y;
    vector.z[lane] = z;
}

fn get<S: Simd>(vector: &Vec3<S>, lane: usize) -> [f64; 3] {
    [number::<S>(&vector.x, lane), number::<S>(&vector.y, lane), number::<S>(&vector.z, lane)]
}

/// A lane's number. A masked lane may have had a zero of either sign added, so zeros are made positive.
fn number<S: Simd>(real: &Real<S>, lane: usize) -> f64 {
    real[lane] + 0.0
}

#[cfg(test)]
mod tests;
