//! The 16 initial postures: four a behaviour, each beside one of the object's areas.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::Behaviour;
use crate::physics::Placement;
use crate::robot::JOINTS;
use crate::scene;

const STARTS: &str = include_str!("../../assets/starts.toml");

/// Why the initial postures cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("initial postures: {0}")]
pub struct StartError(String);

/// An initial posture. Root frame, metres and radians.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Start {
    /// Joint angles.
    pub angles: [f64; JOINTS],
    /// The object, if it is in the hand; without it the object stands on the table.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub in_hand: Option<InHand>,
}

/// An object in the hand.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InHand {
    /// Centre of the object.
    pub object: [f64; 3],
    /// Orientation of the object as a unit quaternion (w, x, y, z).
    pub orientation: [f64; 4],
    /// Angles that the servos are commanded to, so that the fingers press on the object.
    pub targets: [f64; JOINTS],
}

impl Start {
    /// Robot and object at the start of a trial. An object on the table stands at `place` (x, y).
    #[must_use]
    pub fn placement(&self, [x, y]: [f64; 2]) -> Placement {
        let angles = self.angles;
        match self.in_hand {
            Some(InHand { object, orientation, targets }) => {
                Placement { angles, targets, object, orientation }
            }
            None => Placement {
                angles,
                targets: angles,
                object: [x, y, scene::OBJECT_STANDING],
                orientation: [1.0, 0.0, 0.0, 0.0],
            },
        }
    }
}

/// The initial postures of all behaviours; posture `i` belongs to area `i`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Starts {
    /// The hand is far from the object.
    pub reach: [Start; 4],
    /// The fingers are closed.
    pub open: [Start; 4],
    /// The open hand is over the object.
    pub grasp: [Start; 4],
    /// The fingers have closed around the object on the table until they feel it.
    #[serde(rename = "move")]
    pub transport: [Start; 4],
    /// The object is held above the table. No trial begins there: what contacts do is tested with them.
    pub held: [Start; 4],
}

impl Starts {
    /// The shipped postures.
    ///
    /// # Errors
    /// [`StartError`] when the shipped file was damaged; a test holds it.
    pub fn shipped() -> Result<Self, StartError> {
        toml::from_str(STARTS).map_err(|error| StartError(error.message().to_owned()))
    }

    /// The postures of a behaviour. MOVE-TO-TARGET begins where REACH does.
    #[must_use]
    pub fn of(&self, behaviour: Behaviour) -> &[Start; 4] {
        match behaviour {
            Behaviour::Reach | Behaviour::MoveToTarget => &self.reach,
            Behaviour::Open => &self.open,
            Behaviour::Grasp => &self.grasp,
            Behaviour::Move => &self.transport,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::RobotModel;

    #[test]
    fn the_shipped_postures_lie_within_the_joints_limits() {
        let robot = RobotModel::icub().unwrap();
        let starts = Starts::shipped().unwrap();
        for behaviour in Behaviour::ALL {
            for start in starts.of(behaviour) {
                let commanded = start.placement([0.0; 2]).targets;
                for (joint, target) in robot.joints.iter().zip(commanded) {
                    let slack = 1e-6;
                    assert!(target > joint.lower - slack && target < joint.upper + slack, "{}", joint.name);
                }
                assert_eq!(start.in_hand.is_some(), behaviour == Behaviour::Move);
            }
        }
    }
}
