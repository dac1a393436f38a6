//! The four elementary actions and MOVE-TO-TARGET (paper, section II.C): the goal of each, and the graded reward on the
//! way to it.

mod goal;
mod grasp;
mod integrated;
mod open;
mod reach;
mod starts;
mod transport;

use crate::experiment::{self, Experiment, Near};
use crate::physics::Observation;
use crate::robot::RobotModel;
use crate::scene;

pub use goal::{Bound, Condition, Quantity};
pub use starts::{InHand, Start, StartError, Starts};

/// What a trial asks for; the elementary actions in the order of the trials and of the linguistic labels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Behaviour {
    /// Bring the hand over the object.
    Reach,
    /// Open the fingers and turn the palm down.
    Open,
    /// Close the fingers around the object.
    Grasp,
    /// Carry the object to the target.
    Move,
    /// Fetch a distant object and carry it to the target.
    MoveToTarget,
}

impl Behaviour {
    /// The elementary actions, which have labels.
    pub const ELEMENTARY: [Self; 4] = [Self::Reach, Self::Open, Self::Grasp, Self::Move];

    /// All behaviours.
    pub const ALL: [Self; 5] = [Self::Reach, Self::Open, Self::Grasp, Self::Move, Self::MoveToTarget];

    /// Lower-case name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Reach => "reach",
            Self::Open => "open",
            Self::Grasp => "grasp",
            Self::Move => "move",
            Self::MoveToTarget => "move-to-target",
        }
    }

    /// The elementary action that comes before this one when they are done one after the other.
    #[must_use]
    pub const fn before(self) -> Option<Self> {
        match self {
            Self::Reach | Self::MoveToTarget => None,
            Self::Open => Some(Self::Reach),
            Self::Grasp => Some(Self::Open),
            Self::Move => Some(Self::Grasp),
        }
    }

    /// Control steps of a trial.
    #[must_use]
    pub fn steps(self, experiment: &Experiment) -> u32 {
        match self {
            Self::Reach => experiment.reach.steps,
            Self::Open => experiment.open.steps,
            Self::Grasp => experiment.grasp.steps,
            Self::Move => experiment.transport.steps,
            Self::MoveToTarget => experiment.move_to_target.steps,
        }
    }

    /// Whether attention belongs on the target rather than on the object. In MOVE-TO-TARGET it does once the object has
    /// been `lifted`.
    #[must_use]
    pub fn is_about_target(self, lifted: bool) -> bool {
        self == Self::Move || (self == Self::MoveToTarget && lifted)
    }

    /// How the state is judged.
    #[must_use]
    pub fn judge(self, experiment: &Experiment, view: &View<'_>) -> Judgement {
        match self {
            Self::Reach => reach::judge(&experiment.reach, view),
            Self::Open => open::judge(&experiment.open, view),
            Self::Grasp => grasp::judge(&experiment.grasp, view),
            Self::Move => transport::judge(&experiment.transport, view),
            Self::MoveToTarget => integrated::judge(&experiment.move_to_target, view),
        }
    }

    /// What the goal asks for, as it is in a state: the same conditions by which [`Behaviour::judge`] tells the goal.
    #[must_use]
    pub fn conditions(self, experiment: &Experiment, view: &View<'_>) -> Vec<Condition> {
        match self {
            Self::Reach => reach::conditions(&experiment.reach, view).to_vec(),
            Self::Open => open::conditions(&experiment.open, view).to_vec(),
            Self::Grasp => grasp::conditions(&experiment.grasp, view),
            Self::Move => transport::conditions(&experiment.transport, view).to_vec(),
            Self::MoveToTarget => integrated::conditions(&experiment.move_to_target, view).to_vec(),
        }
    }
}

/// How a state is judged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Judgement {
    /// How near the state is to the goal, in [0, 1].
    pub reward: f64,
    /// Whether it is the goal.
    pub goal: bool,
}

/// The state that is judged.
#[derive(Debug, Clone, Copy)]
pub struct View<'a> {
    /// The robot.
    pub robot: &'a RobotModel,
    /// Robot and object.
    pub observation: &'a Observation,
    /// Where the target is; root frame, metres.
    pub target: [f64; 3],
}

impl View<'_> {
    /// Distance from the palm to the top part of the object: the point above its centre on its surface.
    fn palm_to_object(&self) -> f64 {
        let [x, y, z] = self.observation.object;
        distance(self.observation.palm, [x, y, z + scene::OBJECT_RADIUS])
    }

    /// Distance from the object's centre to the centroid of thumb tip, little finger tip and palm.
    fn grip_to_object(&self) -> f64 {
        let Observation { thumb_tip, little_tip, palm, object, .. } = self.observation;
        let centroid = std::array::from_fn(|i| (thumb_tip[i] + little_tip[i] + palm[i]) / 3.0);
        distance(centroid, *object)
    }

    fn object_to_target(&self) -> f64 {
        distance(self.observation.object, self.target)
    }

    /// Cosine of the angle between the palm's outward normal and straight down.
    fn alignment(&self) -> f64 {
        -self.observation.palm_normal[2]
    }

    fn flexion(&self) -> f64 {
        self.robot.flexion(&self.observation.angles)
    }

    fn touches(&self) -> u32 {
        self.observation.touch.iter().map(|touch| u32::from(*touch)).sum()
    }

    /// How undisturbed the object is, in [0, 1]: 1 while it stands, 0 when it lies on its side. A hand that throws it over
    /// cannot go on to grasp it.
    fn standing(&self) -> f64 {
        unit(self.observation.upright())
    }

    /// Height of the object's base above the table while it is upright.
    fn height(&self) -> f64 {
        self.observation.object[2] - scene::OBJECT_STANDING
    }

    /// Whether the hand holds the object above the table, as MOVE asks for.
    #[must_use]
    pub fn is_lifted(&self, settings: &experiment::Move) -> bool {
        self.touches() >= settings.held_touches && self.height() > settings.held_height
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let [x, y, z] = std::array::from_fn(|i| a[i] - b[i]);
    (x * x + y * y + z * z).sqrt()
}

fn unit(x: f64) -> f64 {
    x.clamp(0.0, 1.0)
}

/// Closeness in [0, 1]; see [`Near`].
fn near(settings: &Near, distance: f64) -> f64 {
    let beyond = distance - settings.full;
    (unit(1.0 - beyond / settings.wide) + unit(1.0 - beyond / settings.narrow)) / 2.0
}

/// The palm's alignment with straight down in [0, 1], full from a cosine of `full` on. It falls all the way to a palm
/// that faces up, so that it pulls from everywhere.
fn graded_alignment(cosine: f64, full: f64) -> f64 {
    unit((1.0 + cosine) / (1.0 + full))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closeness_pulls_from_afar_and_harder_nearby() {
        let settings = Near { full: 0.04, wide: 0.26, narrow: 0.08 };
        assert_eq!(near(&settings, 0.04), 1.0);
        assert_eq!(near(&settings, 0.31), 0.0);
        let far = near(&settings, 0.20) - near(&settings, 0.21);
        let close = near(&settings, 0.06) - near(&settings, 0.07);
        assert!(far > 0.0 && close > 3.0 * far, "{far} {close}");
    }

    #[test]
    fn alignment_has_a_slope_wherever_the_palm_faces() {
        assert_eq!(graded_alignment(-1.0, 0.85), 0.0);
        assert!(graded_alignment(0.0, 0.85) > graded_alignment(-0.1, 0.85));
        assert_eq!(graded_alignment(0.9, 0.85), 1.0);
    }
}
