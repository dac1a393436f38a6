//! A stored trial, run again and taken away: as a page that plays it, as JSON, CSV or MCAP, or as pictures.

mod camera;
mod events;
mod mcap;
mod neurons;
mod page;
mod rows;
mod shapes;
mod strip;

use nalgebra::Point3;
use selftalk_sim::behaviours::Condition;
use selftalk_sim::physics::{Observation, TOUCH_SENSOR_NAMES};
use selftalk_sim::robot::{JOINTS, Kinematics, Part, RobotError, RobotModel, joint};
use selftalk_sim::{Behaviour, Frame, Trace, scene};
use serde::Serialize;

pub use events::{Event, What, events};
pub use mcap::{McapFailure, mcap};
pub use neurons::{MOTORS, SENSORS};
pub use page::page;
pub use rows::{Kind, Signal, csv, names, values};
pub use strip::{key_moments, strip};

/// Length of a control step, s.
const STEP: f64 = 0.05;

/// A trial as it went, with all that is needed to draw it. Lengths in metres in the robot's root frame: x backward, y to
/// the robot's right, z up; angles in radians, times in seconds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Recording {
    /// Whose trial.
    pub individual: String,
    /// Trial, counted from 0.
    pub trial: u32,
    /// What it asks for.
    pub behaviour: &'static str,
    /// Its score, in [0, 1].
    pub score: f64,
    /// Whether its goal was reached.
    pub success: bool,
    /// Length of a control step.
    pub step_seconds: f64,
    /// Where the target is.
    pub target: [f64; 3],
    /// Height of the table top.
    pub table: f64,
    /// Radius of the object, and how far below its centre it is cut flat.
    pub object_radius: f64,
    /// See `object_radius`.
    pub object_base: f64,
    /// Names of the joints, in the order of the angles.
    pub joints: Vec<String>,
    /// Lower and upper limits of the joints.
    pub limits: Vec<[f64; 2]>,
    /// Names of the touch sensors.
    pub sensors: [&'static str; 6],
    /// Names of the motor neurons.
    pub motors: [&'static str; 13],
    /// The robot's capsules.
    pub capsules: Vec<CapsuleShape>,
    /// The start, then the state at the end of each control step.
    pub moments: Vec<Moment>,
}

/// A capsule that stands for a part of the robot.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CapsuleShape {
    /// The part.
    pub part: String,
    /// Its radius.
    pub radius: f64,
    /// The touch sensor it carries, by its place in the list of sensors.
    pub sensor: Option<usize>,
}

/// A moment of a trial.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Moment {
    /// Time since the controller took over.
    pub time: f64,
    /// Joint angles.
    pub angles: [f64; JOINTS],
    /// Both ends of each capsule's axis.
    pub capsules: Vec<[[f64; 3]; 2]>,
    /// The corners of the palm's box.
    pub palm: [[f64; 3]; 8],
    /// The origins of the links from the waist to the hand.
    pub arm: Vec<[f64; 3]>,
    /// Centre of the object.
    pub object: [f64; 3],
    /// Orientation of the object as a unit quaternion (w, x, y, z).
    pub orientation: [f64; 4],
    /// Which touch sensors feel the object.
    pub touch: [bool; 6],
    /// What happened in the control step that led here; nothing at the start.
    pub step: Option<Step>,
}

/// A control step.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Step {
    /// The label that the controller heard.
    pub heard: Option<&'static str>,
    /// The label that it said.
    pub said: Option<&'static str>,
    /// Activity of the motor neurons.
    pub motors: Vec<f64>,
    /// Activity of the sensory neurons.
    pub sensors: Vec<f64>,
    /// Activity of the internal neurons.
    pub internal: Vec<f64>,
    /// Activity of the neurons that the second phase adds; 0 where there are none.
    pub added: Vec<f64>,
    /// The graded reward, in [0, 1].
    pub reward: f64,
    /// Whether attention was on what it should have been on.
    pub focused: bool,
    /// Whether the state is the goal.
    pub goal: bool,
    /// What the goal asks for, by name, and what it is.
    pub conditions: Vec<(&'static str, f64)>,
}

impl Recording {
    /// A trial of an individual, from its trace.
    ///
    /// # Errors
    /// [`RobotError`] when the shipped robot is damaged.
    pub fn new(
        individual: String,
        trial: u32,
        behaviour: Behaviour,
        trace: &Trace,
    ) -> Result<Self, RobotError> {
        let robot = RobotModel::icub()?;
        let start = moment(&robot, 0.0, &trace.start, None);
        let later = (1..).zip(&trace.frames).map(|(number, frame)| {
            moment(&robot, STEP * f64::from(number), &frame.observation, Some(step(frame)))
        });
        Ok(Self {
            individual,
            trial,
            behaviour: behaviour.name(),
            score: trace.outcome.score,
            success: trace.outcome.success,
            step_seconds: STEP,
            target: trace.target,
            table: scene::TABLE,
            object_radius: scene::OBJECT_RADIUS,
            object_base: scene::OBJECT_BASE,
            joints: robot.joints.iter().map(|joint| joint.name.clone()).collect(),
            limits: robot.joints.iter().map(|joint| [joint.lower, joint.upper]).collect(),
            sensors: TOUCH_SENSOR_NAMES,
            motors: MOTORS,
            capsules: robot
                .capsules
                .iter()
                .map(|capsule| CapsuleShape {
                    part: part(capsule.part),
                    radius: capsule.radius,
                    sensor: if let Part::Fingertip(finger) = capsule.part { Some(finger + 1) } else { None },
                })
                .collect(),
            moments: std::iter::once(start).chain(later).collect(),
        })
    }
}

fn part(part: Part) -> String {
    let finger = |finger: usize| TOUCH_SENSOR_NAMES.get(finger + 1).copied().unwrap_or("finger");
    match part {
        Part::Forearm => "forearm".to_owned(),
        Part::Proximal(number) => format!("{} base", finger(number)),
        Part::Fingertip(number) => format!("{} tip", finger(number)),
    }
}

fn moment(robot: &RobotModel, time: f64, seen: &Observation, step: Option<Step>) -> Moment {
    let links = Kinematics::new(robot, &seen.angles).links;
    let place = |link: usize, point: &Point3<f64>| (links[link] * point).coords.into();
    let half = robot.palm.half;
    let corner = |number: usize| {
        let side = |axis: usize| if number >> axis & 1 == 0 { -half[axis] } else { half[axis] };
        place(robot.palm.link, &(robot.palm.pose * Point3::new(side(0), side(1), side(2))))
    };
    Moment {
        time,
        angles: seen.angles,
        capsules: robot
            .capsules
            .iter()
            .map(|capsule| [place(capsule.link, &capsule.start), place(capsule.link, &capsule.end)])
            .collect(),
        palm: std::array::from_fn(corner),
        arm: joint::CARRIER.map(|link| place(link, &Point3::origin())).collect(),
        object: seen.object,
        orientation: seen.orientation,
        touch: seen.touch,
        step,
    }
}

fn step(frame: &Frame) -> Step {
    let condition = |condition: &Condition| (condition.quantity.name(), condition.value);
    Step {
        heard: frame.heard.map(Behaviour::name),
        said: frame.said.map(Behaviour::name),
        motors: frame.motors.0.to_vec(),
        sensors: frame.sensors.to_vec(),
        internal: frame.activity.internal.to_vec(),
        added: frame.activity.added.to_vec(),
        reward: frame.reward,
        focused: frame.focused,
        goal: frame.goal,
        conditions: frame.conditions.iter().map(condition).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use selftalk_sim::{Case, Draw, Experiment, Genotype, Simulator};

    /// A short trial of a controller that hardly moves.
    pub(super) fn recording(overrides: &[&str], trial: u32) -> Recording {
        let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
        let experiment = Experiment::from_toml("x", "", &overrides).unwrap();
        let simulator = Simulator::new(&experiment).unwrap();
        let genotype = Genotype::new(vec![0x8000; simulator.gene_count()]);
        let trace = simulator.trace(&genotype, Case::Drawn { draw: Draw::test(0), trial }).unwrap();
        Recording::new("e/0/1/2".to_owned(), trial, simulator.behaviour(trial), &trace).unwrap()
    }

    #[test]
    fn a_recording_has_the_start_and_every_step() {
        let recording = recording(&["open.steps=3"], 4);
        assert_eq!((recording.behaviour, recording.moments.len()), ("open", 4));
        assert!(recording.moments[0].step.is_none());
        assert_eq!(recording.moments[3].time, 3.0 * STEP);
        let step = recording.moments[1].step.as_ref().unwrap();
        assert_eq!((step.heard, step.said), (Some("open"), None));
        assert_eq!(step.conditions.len(), 3);
    }

    #[test]
    fn the_hand_is_drawn_where_it_is() {
        let recording = recording(&["reach.steps=3"], 0);
        let moment = &recording.moments[2];
        let wrist = moment.arm[joint::HAND];
        let forearm = recording.capsules.iter().position(|shape| shape.part == "forearm").unwrap();
        let far = |a: [f64; 3], b: [f64; 3]| {
            let squares = (0..3).map(|i| (a[i] - b[i]) * (a[i] - b[i]));
            squares.sum::<f64>().sqrt()
        };
        assert!(far(moment.capsules[forearm][1], wrist) < 0.03, "the forearm ends at the wrist");
        let centre: [f64; 3] = std::array::from_fn(|i| moment.palm.iter().map(|c| c[i]).sum::<f64>() / 8.0);
        assert!(far(centre, wrist) < 0.05, "the palm is in front of it");
        let tips = recording.capsules.iter().filter(|shape| shape.sensor.is_some()).count();
        assert_eq!(tips, 5);
    }

    #[test]
    fn a_robot_that_talks_to_itself_is_heard() {
        let overrides = ["task=move-to-target", "controller.added=speech", "move_to_target.steps=3"];
        let recording = recording(&overrides, 0);
        let said = |at: usize| {
            let step = recording.moments[at].step.as_ref().unwrap();
            (step.heard, step.said)
        };
        assert_eq!(said(1), (None, Some("reach")), "nothing was said before");
        assert_eq!(said(2).0, Some("reach"));
    }
}
