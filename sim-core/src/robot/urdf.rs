//! From the URDF to the tree of moving links: links behind fixed joints are merged into the link that carries them.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Translation3, Unit, Vector3};
use urdf_rs::{Collision, Geometry, JointType, Link, Pose};

use super::joint;
use super::model::{Body, Capsule, JOINTS, Joint, Palm, Part, RobotError, RobotModel};

/// Where a URDF link sits: the moving link that carries it, and its pose there.
#[derive(Clone, Copy)]
struct Mount {
    carrier: Option<usize>,
    pose: Isometry3<f64>,
}

const ICUB: &str = include_str!("../../assets/icub-left-arm.urdf");

impl RobotModel {
    /// The shipped robot.
    ///
    /// # Errors
    /// [`RobotError`] when the shipped URDF was damaged; a test holds it.
    pub fn icub() -> Result<Self, RobotError> {
        Self::from_urdf(ICUB)
    }

    /// A robot with the iCub's moving joints, palm and fingers, by their names.
    ///
    /// # Errors
    /// [`RobotError`] when it is no URDF, or not one of such a robot.
    pub fn from_urdf(text: &str) -> Result<Self, RobotError> {
        let urdf = urdf_rs::read_from_string(text).map_err(|error| RobotError(error.to_string()))?;
        let mut joints: Vec<Joint> = Vec::with_capacity(JOINTS);
        let mut mounts =
            BTreeMap::from([("root_link", Mount { carrier: None, pose: Isometry3::identity() })]);
        for joint in &urdf.joints {
            let parent = mounts
                .get(joint.parent.link.as_str())
                .copied()
                .ok_or_else(|| RobotError(format!("joint {} stands before its parent's", joint.name)))?;
            let pose = parent.pose * isometry(&joint.origin);
            let mount = match joint.joint_type {
                JointType::Fixed => Mount { carrier: parent.carrier, pose },
                JointType::Revolute => {
                    joints.push(moving_joint(joint, parent.carrier, pose)?);
                    Mount { carrier: Some(joints.len() - 1), pose: Isometry3::identity() }
                }
                _ => return Err(RobotError(format!("joint {} is neither revolute nor fixed", joint.name))),
            };
            mounts.insert(&joint.child.link, mount);
        }
        let mut shapes = Shapes::default();
        for link in &urdf.links {
            let Some(&Mount { carrier: Some(carrier), pose }) = mounts.get(link.name.as_str()) else {
                continue;
            };
            joints[carrier].body.attach(link, &pose);
            for collision in &link.collision {
                shapes.add(&link.name, collision, carrier, &pose)?;
            }
        }
        let found = joints.len();
        let joints = joints
            .try_into()
            .map_err(|_| RobotError(format!("{found} moving joints where the iCub's arm has {JOINTS}")))?;
        let palm = shapes.palm.ok_or_else(|| RobotError("no palm".to_owned()))?;
        Ok(Self { joints, palm, capsules: shapes.capsules })
    }
}

fn isometry(pose: &Pose) -> Isometry3<f64> {
    let [x, y, z] = *pose.xyz;
    let [roll, pitch, yaw] = *pose.rpy;
    Isometry3::from_parts(Translation3::new(x, y, z), Rotation3::from_euler_angles(roll, pitch, yaw).into())
}

fn moving_joint(
    joint: &urdf_rs::Joint,
    parent: Option<usize>,
    origin: Isometry3<f64>,
) -> Result<Joint, RobotError> {
    let [x, y, z] = *joint.axis.xyz;
    let axis = Unit::try_new(Vector3::new(x, y, z), 1e-6)
        .ok_or_else(|| RobotError(format!("joint {} has no axis", joint.name)))?;
    let servo = Servo::of(&joint.name);
    Ok(Joint {
        name: joint.name.clone(),
        parent,
        origin,
        axis,
        lower: joint.limit.lower,
        upper: joint.limit.upper,
        torque_limit: joint.limit.effort,
        stiffness: servo.stiffness,
        damping: joint.dynamics.as_ref().map_or(0.0, |dynamics| dynamics.damping),
        armature: servo.armature,
        body: Body { mass: 0.0, centre: Point3::origin(), inertia: Matrix3::zeros() },
    })
}

/// What a URDF cannot say about a servo.
struct Servo {
    stiffness: f64,
    armature: f64,
}

impl Servo {
    fn of(joint: &str) -> Self {
        if joint.starts_with("l_hand") {
            Self { stiffness: 0.5, armature: 2e-5 }
        } else if joint.starts_with("l_wrist") {
            Self { stiffness: 8.0, armature: 0.004 }
        } else {
            Self { stiffness: 100.0, armature: 0.05 }
        }
    }
}

impl Body {
    /// Adds a URDF link's mass, mounted at `pose`.
    fn attach(&mut self, link: &Link, pose: &Isometry3<f64>) {
        let mass = link.inertial.mass.value;
        if mass == 0.0 {
            return;
        }
        let frame = pose * isometry(&link.inertial.origin);
        let i = &link.inertial.inertia;
        let local = Matrix3::new(i.ixx, i.ixy, i.ixz, i.ixy, i.iyy, i.iyz, i.ixz, i.iyz, i.izz);
        let rotation = frame.rotation.to_rotation_matrix();
        let turned = rotation.matrix() * local * rotation.matrix().transpose();
        let centre = Point3::from(frame.translation.vector);
        let total = self.mass + mass;
        let joint_centre = Point3::from((self.centre.coords * self.mass + centre.coords * mass) / total);
        self.inertia += point_inertia(self.mass, self.centre - joint_centre)
            + point_inertia(mass, centre - joint_centre)
            + turned;
        self.mass = total;
        self.centre = joint_centre;
    }
}

/// Inertia of a point mass at `offset` (parallel-axis theorem).
fn point_inertia(mass: f64, offset: Vector3<f64>) -> Matrix3<f64> {
    (Matrix3::identity() * offset.norm_squared() - offset * offset.transpose()) * mass
}

#[derive(Default)]
struct Shapes {
    palm: Option<Palm>,
    capsules: Vec<Capsule>,
}

impl Shapes {
    fn add(
        &mut self,
        link: &str,
        collision: &Collision,
        carrier: usize,
        pose: &Isometry3<f64>,
    ) -> Result<(), RobotError> {
        let pose = pose * isometry(&collision.origin);
        match &collision.geometry {
            Geometry::Box { size } if carrier == joint::HAND && self.palm.is_none() => {
                let [x, y, z] = **size;
                self.palm = Some(Palm { link: carrier, pose, half: Vector3::new(x, y, z) / 2.0 });
            }
            Geometry::Capsule { radius, length } => {
                let [start, end] = [-0.5, 0.5].map(|side| pose * Point3::new(0.0, 0.0, side * length));
                self.add_capsule(Capsule { part: part(link)?, link: carrier, start, end, radius: *radius });
            }
            _ => return Err(RobotError(format!("link {link}: a shape that is neither capsule nor palm"))),
        }
        Ok(())
    }

    /// Phalanges that continue each other on one moving link become one capsule.
    fn add_capsule(&mut self, capsule: Capsule) {
        if let Some(last) = self.capsules.last_mut()
            && last.link == capsule.link
            && (last.end - capsule.start).norm() < 1e-9
        {
            last.end = capsule.end;
            return;
        }
        self.capsules.push(capsule);
    }
}

fn part(link: &str) -> Result<Part, RobotError> {
    if link == "l_forearm" {
        return Ok(Part::Forearm);
    }
    let finger = ["thumb", "index", "middle", "ring", "little"].iter().position(|name| link.contains(name));
    match (finger, link.rsplit('_').next()) {
        (Some(finger), Some("1")) => Ok(Part::Proximal(finger)),
        (Some(finger), Some("2" | "3")) => Ok(Part::Fingertip(finger)),
        _ => Err(RobotError(format!("link {link} has a shape but is no known part"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shipped_robot_is_read() {
        let robot = RobotModel::icub().unwrap();
        let names: Vec<&str> = robot.joints.iter().map(|joint| joint.name.as_str()).collect();
        assert_eq!(names[joint::TORSO_PITCH], "torso_pitch");
        assert_eq!(names[joint::TORSO_YAW], "torso_yaw");
        assert_eq!(names[joint::FOREARM], "l_wrist_prosup");
        assert_eq!(names[joint::HAND], "l_wrist_yaw");
        assert_eq!(names[joint::THUMB_OPPOSITION], "l_hand_thumb_0_joint");
        assert_eq!(names[19], "l_hand_little_2_joint");
        assert_eq!(robot.capsules.len(), 11);
        assert_eq!(robot.palm.link, joint::HAND);
        let mass: f64 = robot.joints.iter().map(|joint| joint.body.mass).sum();
        assert!((mass - 11.5822072).abs() < 1e-9, "{mass}");
    }

    #[test]
    fn the_last_two_phalanges_are_one_capsule() {
        let robot = RobotModel::icub().unwrap();
        let tip = robot.capsule(Part::Fingertip(2)).unwrap();
        assert_eq!(tip.link, 15);
        assert!(((tip.end - tip.start).norm() - 0.0408).abs() < 1e-9);
    }

    #[test]
    fn other_robots_are_refused() {
        assert!(RobotModel::from_urdf("<robot name=\"x\"><link name=\"root_link\"/></robot>").is_err());
        assert!(RobotModel::from_urdf("no xml").is_err());
    }
}
