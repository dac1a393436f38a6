//! The robot in rapier: a multibody of 20 revolute joints on a fixed root, with the shapes that can touch something.

use rapier3d_f64::prelude::{
    ColliderBuilder, ColliderHandle, ColliderSet, GenericJoint, GenericJointBuilder, JointAxesMask,
    MultibodyIndex, MultibodyJointSet, Pose, RigidBodyBuilder, RigidBodyHandle, RigidBodySet,
};

use super::contact::Role;
use super::convert;
use super::servo::Spring;
use crate::physics::TOUCH_SENSORS;
use crate::robot::{Capsule, JOINTS, Joint, Part, RobotError, RobotModel};

/// Where a revolute joint's angle stands among the six coordinates of a joint: it turns about the x axis.
const ANGLE: usize = 3;

/// Where the robot is found in a world.
#[derive(Debug, Clone)]
pub(super) struct Robot {
    multibody: MultibodyIndex,
    /// What carries a touch sensor: the palm, then the fingertips from thumb to little finger.
    pub(super) sensitive: [ColliderHandle; TOUCH_SENSORS],
}

impl Robot {
    /// Puts the robot into a world, all joints at angle 0.
    pub(super) fn insert(
        model: &RobotModel,
        friction: f64,
        bodies: &mut RigidBodySet,
        colliders: &mut ColliderSet,
        joints: &mut MultibodyJointSet,
    ) -> Result<Self, RobotError> {
        let (root, links) = insert_links(model, bodies);
        let multibody = insert_joints(model, root, &links, joints).ok_or(RobotError::incomplete("tree"))?;
        // Its root is fixed: this takes the root's degrees of freedom from it.
        let tree = joints.get_multibody_mut(multibody).ok_or(RobotError::incomplete("tree"))?;
        tree.forward_kinematics(bodies, true);
        for (i, joint) in model.joints.iter().enumerate() {
            tree.armature_mut()[i] = joint.armature;
        }
        let sensitive = insert_shapes(model, friction, &links, bodies, colliders)?;
        Ok(Self { multibody, sensitive })
    }

    /// Turns the joints to the angles (rad), at rest.
    pub(super) fn place(
        &self,
        bodies: &mut RigidBodySet,
        joints: &mut MultibodyJointSet,
        angles: &[f64; JOINTS],
    ) {
        if let Some(tree) = joints.get_multibody_mut(self.multibody) {
            tree.apply_displacements(angles);
            tree.forward_kinematics(bodies, false);
            tree.update_rigid_bodies(bodies, false);
        }
    }

    /// Sets servos and stops for a step of `step` seconds.
    pub(super) fn drive(
        &self,
        joints: &mut MultibodyJointSet,
        model: &[Joint; JOINTS],
        targets: &[f64; JOINTS],
        step: f64,
    ) {
        let Some(tree) = joints.get_multibody_mut(self.multibody) else { return };
        for (i, (joint, target)) in model.iter().zip(targets).enumerate() {
            let velocity = tree.generalized_velocity()[i];
            let Some(link) = tree.link_mut(i + 1) else { return };
            let spring = Spring::new(joint, *target, link.joint.coords()[ANGLE], velocity, step);
            link.joint.set_spring(ANGLE, spring.stiffness, spring.rest);
            tree.damping_mut()[i] = spring.damping;
        }
    }

    /// Angle of a joint, and pose of the link it moves.
    pub(super) fn link(&self, joints: &MultibodyJointSet, i: usize) -> Option<(f64, Pose)> {
        let link = joints.get_multibody(self.multibody)?.link(i + 1)?;
        Some((link.joint.coords()[ANGLE], *link.local_to_world()))
    }
}

/// The bodies: the root, and the moving links. Their weight is compensated.
fn insert_links(
    model: &RobotModel,
    bodies: &mut RigidBodySet,
) -> (RigidBodyHandle, [RigidBodyHandle; JOINTS]) {
    let root = bodies.insert(RigidBodyBuilder::fixed());
    let links = model.joints.each_ref().map(|joint| {
        let link = RigidBodyBuilder::dynamic().additional_mass_properties(convert::mass(&joint.body));
        bodies.insert(link.gravity_scale(0.0).can_sleep(false))
    });
    (root, links)
}

/// Joins the bodies to one multibody, whose link 0 is the root and link `i + 1` the robot's link `i`.
fn insert_joints(
    model: &RobotModel,
    root: RigidBodyHandle,
    links: &[RigidBodyHandle; JOINTS],
    joints: &mut MultibodyJointSet,
) -> Option<MultibodyIndex> {
    for (joint, link) in model.joints.iter().zip(links) {
        let parent = joint.parent.map_or(root, |parent| links[parent]);
        joints.insert(parent, *link, revolute(joint), true)?;
    }
    Some(joints.rigid_body_link(root)?.multibody)
}

fn revolute(joint: &Joint) -> GenericJoint {
    // The joint's frame, whose x axis is the joint's axis, in the link's frame.
    let frame = Pose::from_rotation(GenericJoint::complete_ang_frame(convert::vector(&joint.axis)));
    GenericJointBuilder::new(JointAxesMask::LOCKED_REVOLUTE_AXES)
        .local_frame1(convert::pose(&joint.origin) * frame)
        .local_frame2(frame)
        .build()
}

fn insert_shapes(
    model: &RobotModel,
    friction: f64,
    links: &[RigidBodyHandle; JOINTS],
    bodies: &mut RigidBodySet,
    colliders: &mut ColliderSet,
) -> Result<[ColliderHandle; TOUCH_SENSORS], RobotError> {
    let mut insert = |shape: ColliderBuilder, link: usize, role: Role| {
        let shape = shape.density(0.0).friction(friction).collision_groups(role.groups());
        colliders.insert_with_parent(shape, links[link], bodies)
    };
    let half = model.palm.half;
    let palm = ColliderBuilder::cuboid(half.x, half.y, half.z).position(convert::pose(&model.palm.pose));
    let mut sensitive = [insert(palm, model.palm.link, Role::Robot); TOUCH_SENSORS];
    for (finger, tip) in sensitive[1..].iter_mut().enumerate() {
        let capsule = model.capsule(Part::Fingertip(finger))?;
        *tip = insert(shape(capsule), capsule.link, Role::Robot);
        let capsule = model.capsule(Part::Proximal(finger))?;
        insert(shape(capsule), capsule.link, Role::Proximal);
    }
    let forearm = model.capsule(Part::Forearm)?;
    insert(shape(forearm), forearm.link, Role::Robot);
    Ok(sensitive)
}

fn shape(capsule: &Capsule) -> ColliderBuilder {
    let [start, end] = [capsule.start, capsule.end].map(|point| convert::vector(&point.coords));
    ColliderBuilder::capsule_from_endpoints(start, end, capsule.radius)
}
