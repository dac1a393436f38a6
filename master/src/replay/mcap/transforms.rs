//! Where the robot's links, the object and the target are, as a tree of frames.

use nalgebra::{Isometry3, Quaternion, UnitQuaternion, Vector3};
use selftalk_sim::robot::{Kinematics, RobotModel};

use super::foxglove::{FrameTransform, FrameTransforms};
use super::scene::{quaternion, vector};
use super::{ROOT, timestamp};
use crate::replay::{Moment, Recording};

/// The frames at a moment. A link's is called as the joint that moves it.
pub(super) fn at(robot: &RobotModel, recording: &Recording, moment: &Moment, time: u64) -> FrameTransforms {
    let links = Kinematics::new(robot, &moment.angles).links;
    let transform = |parent: &str, child: &str, pose: &Isometry3<f64>| FrameTransform {
        timestamp: timestamp(time),
        parent_frame_id: parent.to_owned(),
        child_frame_id: child.to_owned(),
        translation: Some(vector(pose.translation.vector.into())),
        rotation: Some(quaternion(pose.rotation)),
    };
    let link = |(joint, pose): (&selftalk_sim::robot::Joint, &Isometry3<f64>)| match joint.parent {
        Some(parent) => transform(&robot.joints[parent].name, &joint.name, &links[parent].inv_mul(pose)),
        None => transform(ROOT, &joint.name, pose),
    };
    let mut transforms: Vec<FrameTransform> = robot.joints.iter().zip(&links).map(link).collect();
    let [w, i, j, k] = moment.orientation;
    let turn = UnitQuaternion::new_normalize(Quaternion::new(w, i, j, k));
    let object = Isometry3::from_parts(Vector3::from(moment.object).into(), turn);
    transforms.push(transform(ROOT, "object", &object));
    let target = Isometry3::from_parts(Vector3::from(recording.target).into(), UnitQuaternion::identity());
    transforms.push(transform(ROOT, "target", &target));
    FrameTransforms { transforms }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::replay::tests::recording;

    #[test]
    fn frames_lead_from_the_root_to_where_a_link_is() {
        let robot = RobotModel::icub().unwrap();
        let recording = recording(&["reach.steps=3"], 0);
        let moment = &recording.moments[2];
        let frames = at(&robot, &recording, moment, 0).transforms;
        assert_eq!(frames.len(), 22);
        let mut place = Isometry3::identity();
        let mut frame = robot.joints[selftalk_sim::robot::joint::HAND].name.as_str();
        while frame != ROOT {
            let found = frames.iter().find(|other| other.child_frame_id == frame).unwrap();
            let (t, r) = (found.translation.unwrap(), found.rotation.unwrap());
            let turn = UnitQuaternion::new_normalize(Quaternion::new(r.w, r.x, r.y, r.z));
            place = Isometry3::from_parts(Vector3::new(t.x, t.y, t.z).into(), turn) * place;
            frame = &found.parent_frame_id;
        }
        let hand = Vector3::from(moment.arm[selftalk_sim::robot::joint::HAND]);
        assert!((place.translation.vector - hand).norm() < 1e-9);
    }
}
