//! The physics engines and what they have in common.

mod lockstep;
mod rapier;

use thiserror::Error;

use crate::experiment;
use crate::robot::{JOINTS, RobotError, RobotModel};

pub use lockstep::Instructions;

/// Length of a control step in seconds (paper, section II.B).
const CONTROL_STEP: f64 = 0.05;
/// Stiffness of a joint's stop as a multiple of its servo's.
const STOP_STIFFNESS: f64 = 100.0;
/// Ratio of a stop's damping to its stiffness, in seconds.
const STOP_DAMPING: f64 = 0.02;

/// Speed up to which an overlap is undone, m/s.
const CORRECTION_SPEED: f64 = 0.3;

/// Touch sensors: the palm, then the tips of thumb, index, middle, ring and little finger (paper, section II.B).
pub const TOUCH_SENSORS: usize = 6;
/// The touch sensors by name, in their order.
pub const TOUCH_SENSOR_NAMES: [&str; TOUCH_SENSORS] = ["palm", "thumb", "index", "middle", "ring", "little"];

/// Where robot and object are at a moment, at rest. Root frame, metres and radians.
#[derive(Debug, Clone, PartialEq)]
pub struct Placement {
    /// Joint angles.
    pub angles: [f64; JOINTS],
    /// Angles the servos are commanded to.
    pub targets: [f64; JOINTS],
    /// Centre of the object.
    pub object: [f64; 3],
    /// Orientation of the object as a unit quaternion (w, x, y, z).
    pub orientation: [f64; 4],
}

/// What can be seen of robot and object at the end of a control step. Root frame, metres and radians.
#[derive(Debug, Clone, PartialEq)]
pub struct Observation {
    /// Joint angles.
    pub angles: [f64; JOINTS],
    /// The palm's point ([`crate::robot::Palm::point`]).
    pub palm: [f64; 3],
    /// Outward normal of the palm's surface.
    pub palm_normal: [f64; 3],
    /// Tip of the thumb: the far end of its last phalanx's axis.
    pub thumb_tip: [f64; 3],
    /// Tip of the little finger.
    pub little_tip: [f64; 3],
    /// Centre of the object.
    pub object: [f64; 3],
    /// Orientation of the object as a unit quaternion (w, x, y, z).
    pub orientation: [f64; 4],
    /// Which touch sensors the object presses on.
    pub touch: [bool; TOUCH_SENSORS],
}

impl Observation {
    /// How upright the object is: the cosine of the angle between its axis and straight up.
    #[must_use]
    pub fn upright(&self) -> f64 {
        let [_, x, y, _] = self.orientation;
        1.0 - 2.0 * (x * x + y * y)
    }

    /// Whether all numbers are finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        let Self { angles, palm, palm_normal, thumb_tip, little_tip, object, orientation, touch: _ } = self;
        [&angles[..], palm, palm_normal, thumb_tip, little_tip, object, orientation]
            .iter()
            .all(|numbers| numbers.iter().all(|number| number.is_finite()))
    }
}

/// Runs independent copies of robot, table and object, one a lane.
///
/// A lane's course depends on its own placement and commands alone, never on the other lanes.
pub trait Engine {
    /// Number of lanes.
    fn lanes(&self) -> usize;

    /// Starts a lane anew.
    fn place(&mut self, lane: usize, placement: &Placement);

    /// Sets the angles (rad) to which a lane's servos drive the joints from now on.
    fn command(&mut self, lane: usize, targets: &[f64; JOINTS]);

    /// Advances all lanes by one control step.
    fn advance(&mut self);

    /// The state of a lane.
    fn observe(&self, lane: usize) -> Observation;
}

/// Why there is no engine.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum EngineError {
    /// The robot lacks a part the engine needs.
    #[error(transparent)]
    Robot(#[from] RobotError),
    /// The experiment asks for none.
    #[error(
        "engine = \"null\" runs no trials, so there is nothing to be seen of one; expected another engine"
    )]
    Null,
}

/// The engine an experiment asks for. The instruction set matters to the lockstep engine alone.
///
/// # Errors
/// [`EngineError`] when the robot lacks a part the engine needs, or the experiment asks for none.
pub fn engine(
    robot: &RobotModel,
    experiment: &experiment::Experiment,
    instructions: Instructions,
) -> Result<Box<dyn Engine>, EngineError> {
    match experiment.engine {
        experiment::Engine::Lockstep => Ok(lockstep::engine(robot, &experiment.physics, instructions)?),
        experiment::Engine::Rapier => Ok(rapier::engine(robot, &experiment.physics)?),
        experiment::Engine::Null => Err(EngineError::Null),
    }
}
