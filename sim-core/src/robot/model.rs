//! The robot's figures in the form the engines need.

use nalgebra::{Isometry3, Matrix3, Point3, Unit, Vector3};
use thiserror::Error;

use super::joint;

/// Moving joints, and moving links: link `i` is moved by joint `i`.
pub const JOINTS: usize = 20;

/// Why a URDF is not this robot.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("URDF: {0}")]
pub struct RobotError(pub(super) String);

impl RobotError {
    pub(crate) fn incomplete(what: &str) -> Self {
        Self(format!("incomplete {what}"))
    }
}

/// The robot.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotModel {
    /// Joints from the waist outwards; a parent stands before its children.
    pub joints: [Joint; JOINTS],
    /// The palm's shape.
    pub palm: Palm,
    /// The forearm's shape, then the phalanges': thumb, index, middle, ring, little, from the hand outwards.
    pub capsules: Vec<Capsule>,
}

/// A revolute joint with its servo, and the link it moves.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Name in the URDF.
    pub name: String,
    /// The link the joint is mounted on; none for the root link, which does not move.
    pub parent: Option<usize>,
    /// Pose of the link in its parent's frame at angle 0.
    pub origin: Isometry3<f64>,
    /// Axis of rotation in the link's frame.
    pub axis: Unit<Vector3<f64>>,
    /// Smallest angle, rad.
    pub lower: f64,
    /// Largest angle, rad.
    pub upper: f64,
    /// Largest torque of the servo's spring, N m.
    pub torque_limit: f64,
    /// Stiffness of the servo, N m / rad.
    pub stiffness: f64,
    /// Damping of servo and gear, N m s / rad.
    pub damping: f64,
    /// Inertia of the rotor, seen at the joint, kg m^2.
    pub armature: f64,
    /// The link with everything rigidly attached to it.
    pub body: Body,
}

impl Joint {
    /// The angle as a share of the joint's range: 0 at `lower`, 1 at `upper`.
    #[must_use]
    pub fn share(&self, angle: f64) -> f64 {
        (angle - self.lower) / (self.upper - self.lower)
    }

    /// The angle at a share of the range.
    #[must_use]
    pub fn angle(&self, share: f64) -> f64 {
        self.lower + share * (self.upper - self.lower)
    }
}

/// Mass distribution of a link.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass in the link's frame, m.
    pub centre: Point3<f64>,
    /// Inertia about the centre of mass, along the link's axes, kg m^2.
    pub inertia: Matrix3<f64>,
}

/// The parts of the robot that can touch something.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// The forearm, without a touch sensor.
    Forearm,
    /// A finger's first phalanx, without a touch sensor; finger 0 is the thumb, 4 the little finger.
    Proximal(usize),
    /// A finger's last two phalanges, which carry the fingertip's touch sensor.
    Fingertip(usize),
}

/// A capsule fixed to a link.
#[derive(Debug, Clone, PartialEq)]
pub struct Capsule {
    /// What it stands for.
    pub part: Part,
    /// The link it is fixed to.
    pub link: usize,
    /// Start of its axis in the link's frame: the end nearer to the body.
    pub start: Point3<f64>,
    /// End of its axis in the link's frame.
    pub end: Point3<f64>,
    /// Radius.
    pub radius: f64,
}

impl Capsule {
    /// Distance from the capsule's surface to a point of the link's frame; negative inside.
    #[must_use]
    pub fn distance(&self, point: &Point3<f64>) -> f64 {
        let axis = self.end - self.start;
        let share = ((point - self.start).dot(&axis) / axis.norm_squared()).clamp(0.0, 1.0);
        (point - (self.start + axis * share)).norm() - self.radius
    }
}

/// The palm: a box fixed to the hand, facing along its negative y axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Palm {
    /// The link it is fixed to.
    pub link: usize,
    /// Pose of the box's centre in the link's frame.
    pub pose: Isometry3<f64>,
    /// Half of the box's sides.
    pub half: Vector3<f64>,
}

impl Palm {
    /// Where the palm is, in the hand's frame: what closeness is measured from. It is the origin of the iCub's standard
    /// hand frame, the end of its arm's kinematic chain, 62.5 mm from the wrist towards the fingers and 16 mm from its
    /// axis to the palm's side.
    #[must_use]
    pub fn point(&self) -> Point3<f64> {
        Point3::new(0.0625, -0.016, 0.0)
    }

    /// The outward normal of the palm's surface in the hand's frame.
    #[must_use]
    pub fn normal(&self) -> Vector3<f64> {
        self.pose * Vector3::new(0.0, -1.0, 0.0)
    }
}

impl RobotModel {
    /// Mean flexion of all finger joints, as a share of their ranges: 0 stretched, 1 closed.
    #[must_use]
    pub fn flexion(&self, angles: &[f64; JOINTS]) -> f64 {
        let shares = joint::FLEXION.map(|i| self.joints[i].share(angles[i]));
        shares.sum::<f64>() / joint::FLEXION.len() as f64
    }

    /// The capsule that stands for a part.
    ///
    /// # Errors
    /// [`RobotError`] when the robot has no such part.
    pub fn capsule(&self, part: Part) -> Result<&Capsule, RobotError> {
        self.capsules
            .iter()
            .find(|capsule| capsule.part == part)
            .ok_or_else(|| RobotError(format!("no collision shape for {part:?}")))
    }
}
