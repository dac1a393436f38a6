//! The rapier engine: one trial at a time in [rapier](https://rapier.rs), a general engine of rigid bodies. It is slow,
//! and the reference for the lockstep engine, with which it shares robot, scene and servos, but no way to solve them.
//!
//! A world has the robot as a multibody ([`robot`]) whose joint springs are the servos ([`servo`]), table and object
//! ([`object`]), and rapier's contacts between them ([`contact`]). A trial begins in a new world ([`world`]). All is in
//! the root frame, in metres, kilograms, seconds and radians.
//!
//! Built with its feature `enhanced-determinism`, rapier gives the same bits on every machine: no mathematics of the
//! platform, no order of a hash map, no threads. The kernels that nalgebra chooses by instruction set multiply matrices
//! of more than five rows and columns each; rapier multiplies none such.

mod contact;
mod convert;
mod object;
mod robot;
mod servo;
mod world;

use nalgebra::{Point3, Vector3};

use self::world::{Blueprint, World};
use super::{Engine, Observation, Placement};
use crate::experiment::Physics;
use crate::robot::{JOINTS, Joint, Part, RobotError, RobotModel, joint};

pub(super) fn engine(model: &RobotModel, physics: &Physics) -> Result<Box<dyn Engine>, RobotError> {
    Ok(Box::new(Rapier::new(model, physics)?))
}

/// A link, and a point in its frame.
type Landmark = (usize, Point3<f64>);

struct Rapier {
    joints: [Joint; JOINTS],
    palm: Point3<f64>,
    palm_normal: Vector3<f64>,
    thumb_tip: Landmark,
    little_tip: Landmark,
    substeps: u32,
    blueprint: Blueprint,
    world: World,
    targets: [f64; JOINTS],
}

impl Rapier {
    fn new(model: &RobotModel, physics: &Physics) -> Result<Self, RobotError> {
        let tip = |finger| model.capsule(Part::Fingertip(finger)).map(|capsule| (capsule.link, capsule.end));
        let blueprint = Blueprint::new(model, physics)?;
        // Until there is a trial.
        let targets = model.joints.each_ref().map(|joint| 0.0_f64.clamp(joint.lower, joint.upper));
        let object = [0.0, 0.0, 1e3];
        let idle = Placement { angles: targets, targets, object, orientation: [1.0, 0.0, 0.0, 0.0] };
        Ok(Self {
            joints: model.joints.clone(),
            palm: model.palm.point(),
            palm_normal: model.palm.normal(),
            thumb_tip: tip(0)?,
            little_tip: tip(4)?,
            substeps: physics.substeps,
            world: blueprint.build(&idle),
            blueprint,
            targets,
        })
    }

    fn point(&self, (link, point): Landmark) -> [f64; 3] {
        (self.world.link(link).1 * point).into()
    }
}

impl Engine for Rapier {
    fn lanes(&self) -> usize {
        1
    }

    fn place(&mut self, lane: usize, placement: &Placement) {
        self.world = self.blueprint.build(placement);
        self.command(lane, &placement.targets);
    }

    fn command(&mut self, _: usize, targets: &[f64; JOINTS]) {
        self.targets = std::array::from_fn(|i| targets[i].clamp(self.joints[i].lower, self.joints[i].upper));
    }

    fn advance(&mut self) {
        for _ in 0..self.substeps {
            self.world.step(&self.joints, &self.targets);
        }
    }

    fn observe(&self, _: usize) -> Observation {
        let (_, hand) = self.world.link(joint::HAND);
        let object = self.world.object();
        let q = object.rotation;
        Observation {
            angles: std::array::from_fn(|i| self.world.link(i).0),
            palm: (hand * self.palm).into(),
            palm_normal: (hand * self.palm_normal).into(),
            thumb_tip: self.point(self.thumb_tip),
            little_tip: self.point(self.little_tip),
            object: object.translation.vector.into(),
            orientation: [q.w, q.i, q.j, q.k],
            touch: self.world.touch(),
        }
    }
}

#[cfg(test)]
mod tests;
