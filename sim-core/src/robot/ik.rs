//! Inverse kinematics of the hand: damped least squares (Wampler 1986) over torso and arm, with the freedom that is
//! left used to stay near a preferred posture.

use nalgebra::{Point3, SMatrix, SVector, Vector3};

use super::joint;
use super::kinematics::Kinematics;
use super::model::{JOINTS, RobotModel};

/// Where a point of the hand should be, and how the hand should slope; its heading is left free. Root frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HandGoal {
    /// The point, in the hand's frame.
    pub point: Point3<f64>,
    /// Where it should be.
    pub position: Point3<f64>,
    /// Angle by which the stretched fingers (the hand's x axis) point below the horizontal, in radians.
    pub tilt: f64,
    /// Angle by which the thumb's side of the hand (its z axis) is higher than the other, in radians. With both
    /// angles 0 the palm faces straight down.
    pub roll: f64,
}

const CARRIER: usize = joint::CARRIER.end;
/// Position, and the heights of the hand's x and z axes.
const ROWS: usize = 5;
const ITERATIONS: usize = 400;
/// Damping of the least squares; a small one suffices away from the arm's reach.
const DAMPING: f64 = 0.02;
/// Share of the way to the preferred posture that is gone in an iteration, where the goal leaves it free.
const PULL: f64 = 0.05;
/// Remaining error up to which a goal counts as reached: metres and sines.
const TOLERANCE: f64 = 1e-4;

impl RobotModel {
    /// Angles of torso and arm, within the joints' limits, that bring the hand to a goal, starting from `start` and
    /// staying near it where the goal leaves freedom; the fingers' angles are `start`'s. None where there is no way.
    #[must_use]
    pub fn bring_hand(&self, goal: &HandGoal, start: &[f64; JOINTS]) -> Option<[f64; JOINTS]> {
        let mut angles = *start;
        for _ in 0..ITERATIONS {
            let (error, jacobian) = self.hand_error(goal, &angles);
            let normal = jacobian * jacobian.transpose()
                + SMatrix::<f64, ROWS, ROWS>::identity() * (DAMPING * DAMPING);
            let inverse = normal.try_inverse()?;
            let pull = SVector::<f64, CARRIER>::from_fn(|i, _| (start[i] - angles[i]) * PULL);
            let step = jacobian.transpose() * (inverse * (error - jacobian * pull)) + pull;
            for (i, joint) in self.joints[joint::CARRIER].iter().enumerate() {
                angles[i] = (angles[i] + step[i].clamp(-0.2, 0.2)).clamp(joint.lower, joint.upper);
            }
        }
        (self.hand_error(goal, &angles).0.norm() < TOLERANCE).then_some(angles)
    }

    /// What is missing to the goal, and its derivative by the carrier's joints.
    fn hand_error(
        &self,
        goal: &HandGoal,
        angles: &[f64; JOINTS],
    ) -> (SVector<f64, ROWS>, SMatrix<f64, ROWS, CARRIER>) {
        let kinematics = Kinematics::new(self, angles);
        let hand = kinematics.links[joint::HAND];
        let point = hand * goal.point;
        let missing = goal.position - point;
        let (fingers, side) = (hand * Vector3::x(), hand * Vector3::z());
        let slope = [-libm::sin(goal.tilt) - fingers.z, libm::sin(goal.roll) - side.z];
        let error = SVector::<f64, ROWS>::new(missing.x, missing.y, missing.z, slope[0], slope[1]);
        let columns = kinematics.jacobian(self, joint::HAND, &point);
        let jacobian = SMatrix::from_fn(|row, column| match row {
            3 => kinematics.axes[column].cross(&fingers).z,
            4 => kinematics.axes[column].cross(&side).z,
            _ => columns[column][row],
        });
        (error, jacobian)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_goal_over_the_table_is_reached_within_the_limits() {
        let robot = RobotModel::icub().unwrap();
        let goal = HandGoal {
            point: Point3::new(0.075, -0.055, 0.025),
            position: Point3::new(-0.30, -0.10, 0.02),
            tilt: 0.0,
            roll: 0.0,
        };
        let mut start = robot.joints.each_ref().map(|joint| joint.angle(0.5));
        start[joint::TORSO_PITCH] = 0.0;
        start[joint::TORSO_YAW] = 0.0;
        let angles = robot.bring_hand(&goal, &start).unwrap();
        let hand = Kinematics::new(&robot, &angles).links[joint::HAND];
        assert!((hand * goal.point - goal.position).norm() < 1e-4);
        let normal = hand * Vector3::new(0.0, -1.0, 0.0);
        assert!(normal.z < -0.95, "{normal}");
        for (angle, joint) in angles.iter().zip(&robot.joints) {
            assert!((joint.lower..=joint.upper).contains(angle), "{} {angle}", joint.name);
        }
    }

    #[test]
    fn a_goal_out_of_reach_is_refused() {
        let robot = RobotModel::icub().unwrap();
        let goal =
            HandGoal { point: Point3::origin(), position: Point3::new(-2.0, 0.0, 0.0), tilt: 0.0, roll: 0.0 };
        assert_eq!(robot.bring_hand(&goal, &[0.3; JOINTS]), None);
    }
}
