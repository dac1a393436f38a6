//! A world with robot, table and object.

use nalgebra::Isometry3;
use rapier3d_f64::prelude::{
    ColliderSet, IntegrationParameters, MultibodyJointSet, PhysicsWorld, RigidBodySet, Vector,
};

use super::object::Objects;
use super::robot::Robot;
use super::{contact, convert};
use crate::experiment::Physics;
use crate::physics::{Placement, TOUCH_SENSORS};
use crate::robot::{JOINTS, Joint, RobotError, RobotModel};
use crate::scene;

/// What every world begins as.
pub(super) struct Blueprint {
    parameters: IntegrationParameters,
    bodies: RigidBodySet,
    colliders: ColliderSet,
    joints: MultibodyJointSet,
    robot: Robot,
    objects: Objects,
}

/// A world in which a trial runs.
pub(super) struct World {
    physics: PhysicsWorld,
    robot: Robot,
    objects: Objects,
    /// Whether all of it is finite. What is not, rapier would take out of the world and go on with the rest; here the
    /// world stops.
    finite: bool,
}

impl Blueprint {
    pub(super) fn new(model: &RobotModel, physics: &Physics) -> Result<Self, RobotError> {
        let mut bodies = RigidBodySet::new();
        let mut colliders = ColliderSet::new();
        let mut joints = MultibodyJointSet::new();
        let objects = Objects::insert(physics.friction, &mut bodies, &mut colliders);
        let robot = Robot::insert(model, physics.friction, &mut bodies, &mut colliders, &mut joints)?;
        Ok(Self { parameters: contact::parameters(physics), bodies, colliders, joints, robot, objects })
    }

    /// A world in which nothing has happened yet.
    pub(super) fn build(&self, placement: &Placement) -> World {
        let mut physics = PhysicsWorld {
            gravity: Vector::Z * -scene::GRAVITY,
            integration_parameters: self.parameters,
            bodies: self.bodies.clone(),
            colliders: self.colliders.clone(),
            multibody_joints: self.joints.clone(),
            ..PhysicsWorld::new()
        };
        let Placement { angles, targets: _, object, orientation } = placement;
        self.robot.place(&mut physics.bodies, &mut physics.multibody_joints, angles);
        self.objects.place(&mut physics.bodies, *object, *orientation);
        World { physics, robot: self.robot.clone(), objects: self.objects, finite: true }
    }
}

impl World {
    /// A physics step, in which the servos drive the joints to the targets (rad).
    pub(super) fn step(&mut self, joints: &[Joint; JOINTS], targets: &[f64; JOINTS]) {
        if !self.finite {
            return;
        }
        let step = self.physics.integration_parameters.dt;
        self.robot.drive(&mut self.physics.multibody_joints, joints, targets, step);
        self.physics.step_with_events(&self.objects, &());
        self.finite = self.physics.quarantine().is_empty();
    }

    /// Angle of joint `i` (rad), and pose of the link it moves.
    pub(super) fn link(&self, i: usize) -> (f64, Isometry3<f64>) {
        let link = self.robot.link(&self.physics.multibody_joints, i).filter(|_| self.finite);
        link.map_or_else(|| (f64::NAN, convert::nowhere()), |(angle, pose)| (angle, convert::isometry(&pose)))
    }

    /// Pose of the object.
    pub(super) fn object(&self) -> Isometry3<f64> {
        let object = self.physics.bodies.get(self.objects.object).filter(|_| self.finite);
        object.map_or_else(convert::nowhere, |object| convert::isometry(object.position()))
    }

    /// Whether the object pressed on each touch sensor in the last step.
    pub(super) fn touch(&self) -> [bool; TOUCH_SENSORS] {
        self.robot.sensitive.map(|sensor| {
            let pair = self.physics.narrow_phase.contact_pair(self.objects.ball, sensor);
            pair.is_some_and(|pair| pair.has_any_active_contact() && pair.total_impulse_magnitude() > 0.0)
        })
    }
}
