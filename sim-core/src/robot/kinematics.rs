//! Forward kinematics of one posture, in plain scalars: the reference the lanes are held against, and what inverse
//! kinematics is computed with.

use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};

use super::model::{JOINTS, RobotModel};

/// The poses of all links in the root frame.
#[derive(Debug, Clone)]
pub struct Kinematics {
    /// Pose of each link.
    pub links: [Isometry3<f64>; JOINTS],
    /// Axis of each joint in the root frame.
    pub axes: [Vector3<f64>; JOINTS],
}

impl Kinematics {
    /// The poses at the given joint angles (rad).
    #[must_use]
    pub fn new(robot: &RobotModel, angles: &[f64; JOINTS]) -> Self {
        let mut links = [Isometry3::identity(); JOINTS];
        let mut axes = [Vector3::zeros(); JOINTS];
        for (i, joint) in robot.joints.iter().enumerate() {
            let parent = joint.parent.map_or_else(Isometry3::identity, |parent| links[parent]);
            links[i] = parent * joint.origin * UnitQuaternion::from_axis_angle(&joint.axis, angles[i]);
            axes[i] = links[i] * joint.axis.into_inner();
        }
        Self { links, axes }
    }

    /// The velocity of a point, fixed to `link` and now at `point` in the root frame, for each joint's unit
    /// velocity: the translational Jacobian, one column a joint, zero where the joint does not carry the link.
    #[must_use]
    pub fn jacobian(&self, robot: &RobotModel, link: usize, point: &Point3<f64>) -> [Vector3<f64>; JOINTS] {
        let mut columns = [Vector3::zeros(); JOINTS];
        let mut next = Some(link);
        while let Some(i) = next {
            columns[i] = self.axes[i].cross(&(point - Point3::from(self.links[i].translation.vector)));
            next = robot.joints[i].parent;
        }
        columns
    }
}
