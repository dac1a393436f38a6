//! Between network and robot: what the sensory neurons see, and what the motor neurons command (paper, section II.B).

use crate::behaviours::Behaviour;
use crate::controller::{Motors, SENSORS};
use crate::experiment;
use crate::physics::{Observation, TOUCH_SENSORS};
use crate::robot::{JOINTS, RobotModel, joint};

/// First of the sensors that stand for linguistic labels, in the order of [`Behaviour::ELEMENTARY`].
const LABELS: usize = SENSORS - Behaviour::ELEMENTARY.len();

/// Activity of the sensory neurons: position of object or target relative to the palm (3), proprioception (12), touch
/// (6) and linguistic label (4).
///
/// A position is given along the axes of the root frame, as a multiple of `position_scale`, up to `position_limit`.
/// Proprioceptors give a joint's angle as a share of its range: torso rotation and flexion, the arm's seven joints,
/// and as means over their joints thumb flexion, thumb opposition and finger flexion: the motors' order.
#[must_use]
pub fn sense(
    robot: &RobotModel,
    settings: &experiment::Controller,
    observation: &Observation,
    attended: &[f64; 3],
    label: Option<Behaviour>,
) -> [f64; SENSORS] {
    let mut sensors = [0.0; SENSORS];
    let (position, rest) = sensors.split_at_mut(3);
    for ((sensor, thing), palm) in position.iter_mut().zip(attended).zip(observation.palm) {
        let bound = settings.position_limit;
        *sensor = ((thing - palm) / settings.position_scale).clamp(-bound, bound);
    }
    let share = |i: usize| robot.joints[i].share(observation.angles[i]);
    let (proprioception, rest) = rest.split_at_mut(12);
    proprioception[0] = share(joint::TORSO_YAW);
    proprioception[1] = share(joint::TORSO_PITCH);
    for (sensor, i) in proprioception[2..9].iter_mut().zip(joint::ARM) {
        *sensor = share(i);
    }
    proprioception[9] = mean(joint::THUMB_FLEXION.map(share));
    proprioception[10] = share(joint::THUMB_OPPOSITION);
    proprioception[11] = mean(joint::FINGER_FLEXION.map(share));
    for (sensor, touch) in rest[..TOUCH_SENSORS].iter_mut().zip(observation.touch) {
        *sensor = f64::from(u8::from(touch));
    }
    for (sensor, of) in sensors[LABELS..].iter_mut().zip(Behaviour::ELEMENTARY) {
        *sensor = f64::from(u8::from(label == Some(of)));
    }
    sensors
}

/// Desired joint angles: each motor neuron's activity is mapped linearly onto the range of its joints. All joints of
/// a finger group follow one motor, and each yields on its own.
#[must_use]
pub fn command(robot: &RobotModel, motors: &Motors) -> [f64; JOINTS] {
    let Motors([_focus, torso_yaw, torso_pitch, arm @ .., thumb_flexion, opposition, finger_flexion]) =
        motors;
    std::array::from_fn(|i| {
        let share = match i {
            joint::TORSO_YAW => *torso_yaw,
            joint::TORSO_PITCH => *torso_pitch,
            joint::THUMB_OPPOSITION => *opposition,
            _ if joint::ARM.contains(&i) => arm[i - joint::ARM.start],
            _ if joint::THUMB_FLEXION.contains(&i) => *thumb_flexion,
            _ => *finger_flexion,
        };
        robot.joints[i].angle(share)
    })
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::controller::MOTORS;

    fn observation() -> Observation {
        let robot = RobotModel::icub().unwrap();
        Observation {
            angles: robot.joints.each_ref().map(|joint| joint.angle(0.25)),
            palm: [-0.2, -0.1, 0.1],
            palm_normal: [0.0, 0.0, -1.0],
            thumb_tip: [0.0; 3],
            little_tip: [0.0; 3],
            object: [0.0; 3],
            orientation: [1.0, 0.0, 0.0, 0.0],
            touch: [true, false, false, true, false, false],
        }
    }

    #[test]
    fn sensors_are_in_their_places() {
        let robot = RobotModel::icub().unwrap();
        let settings = experiment::Controller::default();
        let sensors = sense(&robot, &settings, &observation(), &[-0.25, -0.1, 0.9], Some(Behaviour::Grasp));
        assert!((sensors[0] * settings.position_scale + 0.05).abs() < 1e-12, "5 cm in front: {}", sensors[0]);
        assert_eq!(sensors[2], settings.position_limit, "far above, clipped");
        for share in &sensors[3..15] {
            assert!((share - 0.25).abs() < 1e-12);
        }
        assert_eq!(sensors[15..21], [1.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
        assert_eq!(sensors[21..], [0.0, 0.0, 1.0, 0.0]);
    }

    #[test]
    fn motors_drive_the_joints_that_proprioception_reports() {
        let robot = RobotModel::icub().unwrap();
        let settings = experiment::Controller::default();
        let activity: [f64; MOTORS] = std::array::from_fn(|i| i as f64 / 12.0);
        let angles = command(&robot, &Motors(activity));
        let sensors = sense(&robot, &settings, &Observation { angles, ..observation() }, &[0.0; 3], None);
        for (sensor, motor) in sensors[3..15].iter().zip(&activity[1..]) {
            assert!((sensor - motor).abs() < 1e-12, "{sensors:?}");
        }
    }
}
