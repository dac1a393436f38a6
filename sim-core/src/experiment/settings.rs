//! The sections of an experiment file. "Paper" marks a value the paper gives; the others are ours.

use serde::{Deserialize, Serialize};

use super::integration::Added;
use crate::scene;

/// Which physics engine runs the trials.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Engine {
    /// Trials side by side in vector lanes, written for this robot.
    #[default]
    Lockstep,
    /// One trial at a time in rapier, a general engine of rigid bodies: slow, the reference.
    Rapier,
    /// None: outcomes that cost nothing and mean nothing, to test and measure all that is around the simulator.
    Null,
}

impl Engine {
    /// All engines.
    pub const ALL: [Self; 3] = [Self::Lockstep, Self::Rapier, Self::Null];
    /// Those that simulate anything.
    pub const SIMULATED: [Self; 2] = [Self::Lockstep, Self::Rapier];

    /// The name in the experiment file.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Lockstep => "lockstep",
            Self::Rapier => "rapier",
            Self::Null => "null",
        }
    }

    /// The one to check this one with.
    #[must_use]
    pub const fn other(self) -> Self {
        match self {
            Self::Lockstep => Self::Rapier,
            Self::Rapier | Self::Null => Self::Lockstep,
        }
    }
}

/// Selection and variation (paper, section II.C).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Evolution {
    /// Genotypes in a generation; paper: 100.
    pub population: u32,
    /// Best genotypes that reproduce; paper: 20. `parents * offspring` is `population`.
    pub parents: u32,
    /// Offspring of each parent, the first of them unvaried; paper: 5.
    pub offspring: u32,
    /// Probability with which each bit of a varied offspring flips; paper, first phase: 0.005 %.
    pub mutation: f64,
    /// Generations after which object and target positions are drawn anew.
    pub draws_every: u32,
    /// Whether a replication ends with its first individual that succeeds in all trials.
    pub stop_at_optimum: bool,
}

impl Default for Evolution {
    fn default() -> Self {
        Self {
            population: 100,
            parents: 20,
            offspring: 5,
            mutation: 0.00005,
            draws_every: 1,
            stop_at_optimum: false,
        }
    }
}

/// The neural controller (paper, section II.B).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Controller {
    /// Weights and biases lie in [-weight_range, weight_range]; paper: 1.
    pub weight_range: f64,
    /// Slope of the logistic function.
    pub slope: f64,
    /// Distance along an axis that a position sensor reports as 1, in metres.
    pub position_scale: f64,
    /// Bound of a position sensor's magnitude.
    pub position_limit: f64,
    /// Whether the 15 internal neurons are connected among themselves.
    pub recurrent: bool,
    /// Neurons that the second phase adds.
    pub added: Added,
}

impl Default for Controller {
    fn default() -> Self {
        Self {
            weight_range: 1.0,
            slope: 3.0,
            position_scale: 0.025,
            position_limit: 10.0,
            recurrent: false,
            added: Added::None,
        }
    }
}

/// Settings of the physics engine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Physics {
    /// Physics steps in a control step of 50 ms.
    pub substeps: u32,
    /// Most Gauss-Seidel sweeps over the contacts in a physics step; a trial's end early once they change nothing.
    pub sweeps: u32,
    /// Coulomb friction coefficient of every contact.
    pub friction: f64,
}

impl Default for Physics {
    fn default() -> Self {
        Self { substeps: 8, sweeps: 16, friction: 1.0 }
    }
}

/// Where object and target are placed; root frame, metres (paper, section II.A).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Scene {
    /// Middle of the object's four areas along x; paper: 30 cm in front.
    pub areas_x: f64,
    /// Middle of the object's four areas along y; paper: 10 cm to the left.
    pub areas_y: f64,
    /// Distance of each area's centre from their middle: to the front, back, left and right; paper: 0.10.
    pub areas_distance: f64,
    /// Distance of both target areas in front of the robot; paper: 0.25.
    pub target_front: f64,
    /// Distance of the target areas to the left and to the right; paper: 0.10.
    pub target_side: f64,
    /// Height of the target areas above the table; paper: 0.25.
    pub target_height: f64,
    /// The object is moved by up to this much from its area's centre along x and y; paper: 0.02.
    pub object_jitter: f64,
    /// Share of `object_jitter` that is used in GRASP, whose hand starts over the object.
    pub grasp_jitter_share: f64,
    /// The target is moved by up to this much from its area's centre along x, y and z.
    pub target_jitter: f64,
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            areas_x: scene::AREAS_CENTRE[0],
            areas_y: scene::AREAS_CENTRE[1],
            areas_distance: scene::AREAS_DISTANCE,
            target_front: 0.25,
            target_side: 0.10,
            target_height: 0.25,
            object_jitter: 0.02,
            grasp_jitter_share: 1.0,
            target_jitter: 0.02,
        }
    }
}

/// What the trials of all behaviours share.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Trials {
    /// Control steps for which the goal must hold without a break to count as reached.
    pub hold: u32,
    /// Most control steps in which the controller hears the label of the action before this one, at the beginning of
    /// a trial of OPEN, GRASP or MOVE, before what it does is judged. How many there are is drawn for each trial.
    pub lead_in: u32,
    /// Whether a trial of an elementary action ends when its goal has been reached; one of MOVE-TO-TARGET always does.
    pub end_at_goal: bool,
    /// Share of the score that reaching the goal gives; the rest is the mean of the graded reward.
    pub goal_share: f64,
    /// Factor on the graded reward while the focus is on the wrong thing.
    pub wrong_focus: f64,
}

impl Default for Trials {
    fn default() -> Self {
        Self { hold: 3, lead_in: 0, end_at_goal: false, goal_share: 0.2, wrong_focus: 0.3 }
    }
}

/// Closeness, as rewards grade it: the mean of two ramps, each 1 up to distance `full` and 0 from `full` plus its own
/// width on. The wide one pulls from afar, the narrow one harder near the goal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Near {
    /// Distance up to which closeness is 1, in metres.
    pub full: f64,
    /// Width of the wide ramp, in metres.
    pub wide: f64,
    /// Width of the narrow ramp, in metres.
    pub narrow: f64,
}

impl Default for Near {
    fn default() -> Self {
        Self { full: 0.04, wide: 0.26, narrow: 0.2 }
    }
}

/// REACH: the palm comes close to the top of the object.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Reach {
    /// Length of a trial in control steps.
    pub steps: u32,
    /// The goal: the palm is closer than this to the top of the object, in metres; paper: 0.06.
    pub goal_distance: f64,
    /// How closeness of palm and object is graded.
    pub near: Near,
    /// Weight of closeness in the graded reward; the rest is the palm's alignment with straight down.
    pub near_weight: f64,
    /// Cosine of the angle between the palm's outward normal and straight down from which on alignment is fully
    /// rewarded.
    pub full_alignment: f64,
}

impl Default for Reach {
    fn default() -> Self {
        Self {
            steps: 30,
            goal_distance: 0.06,
            near: Near::default(),
            near_weight: 0.75,
            full_alignment: 0.85,
        }
    }
}

/// OPEN: the fingers are stretched and the palm faces down, close to the top of the object.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Open {
    /// Length of a trial in control steps.
    pub steps: u32,
    /// The goal's distance from palm to the top of the object, in metres; paper: 0.06.
    pub goal_distance: f64,
    /// The goal's extension of the fingers: 1 minus their mean flexion, as shares of their ranges.
    pub goal_extension: f64,
    /// The goal's alignment: cosine of the angle between the palm's outward normal and straight down.
    pub goal_alignment: f64,
    /// Extension from which on it is fully rewarded: beyond the goal, so that there is a pull up to it.
    pub full_extension: f64,
    /// Alignment from which on it is fully rewarded.
    pub full_alignment: f64,
    /// How closeness of palm and object is graded.
    pub near: Near,
}

impl Default for Open {
    fn default() -> Self {
        Self {
            steps: 30,
            goal_distance: 0.06,
            goal_extension: 0.7,
            goal_alignment: 0.8,
            full_extension: 0.8,
            full_alignment: 0.95,
            near: Near::default(),
        }
    }
}

/// GRASP: the fingers close around the object.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Grasp {
    /// Length of a trial in control steps.
    pub steps: u32,
    /// The goal's distance from the object's centre to the centroid of thumb tip, little finger tip and palm, in metres.
    pub goal_distance: f64,
    /// The goal's number of touch sensors in contact with the object; the caretaker's rule in the paper: 3.
    pub goal_touches: u32,
    /// The goal's height of the object's base above the table, in metres; 0 where it need not be raised, as in the
    /// paper.
    pub goal_height: f64,
    /// Weight of that height in the graded reward where it is asked for; the rest is for the other terms.
    pub height_weight: f64,
    /// How closeness of that centroid is graded.
    pub near: Near,
    /// Weight of closeness in the graded reward.
    pub near_weight: f64,
    /// Weight of the fingers' flexion; the rest is the share of `goal_touches` in contact.
    pub flexion_weight: f64,
    /// Mean flexion, as a share of the range, from which on it is fully rewarded.
    pub full_flexion: f64,
}

impl Default for Grasp {
    fn default() -> Self {
        Self {
            steps: 30,
            goal_distance: 0.04,
            goal_touches: 3,
            goal_height: 0.0,
            height_weight: 0.4,
            near: Near { narrow: 0.08, ..Near::default() },
            near_weight: 0.5,
            flexion_weight: 0.2,
            full_flexion: 0.5,
        }
    }
}

/// MOVE: the object is carried to the target.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Move {
    /// Length of a trial in control steps.
    pub steps: u32,
    /// The goal: the object is closer than this to the target, in metres; paper: 0.06.
    pub goal_distance: f64,
    /// How closeness of object and target is graded.
    pub near: Near,
    /// Weight of closeness in the graded reward; the rest is given while the object is held.
    pub near_weight: f64,
    /// Touch sensors in contact from which on the object counts as held.
    pub held_touches: u32,
    /// Height of the object's base above the table from which on it counts as held, in metres.
    pub held_height: f64,
}

impl Default for Move {
    fn default() -> Self {
        Self {
            steps: 50,
            goal_distance: 0.06,
            near: Near::default(),
            near_weight: 0.8,
            held_touches: 2,
            held_height: 0.04,
        }
    }
}
