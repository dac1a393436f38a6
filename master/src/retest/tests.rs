//! What is said of trials that failed.

use selftalk_sim::behaviours::{Bound, Condition, Quantity};
use selftalk_sim::controller::{Activity, MOTORS, Motors, SENSORS};
use selftalk_sim::physics::{Observation, TOUCH_SENSORS};
use selftalk_sim::robot::JOINTS;
use selftalk_sim::{Behaviour, Experiment, Frame, Trace, TrialOutcome, scene};

use super::Course;

/// An experiment whose trials are this short, in control steps.
pub(super) fn brief(steps: u32) -> Experiment {
    let mut experiment = Experiment::default();
    for length in [
        &mut experiment.reach.steps,
        &mut experiment.open.steps,
        &mut experiment.grasp.steps,
        &mut experiment.transport.steps,
    ] {
        *length = steps;
    }
    experiment
}

/// The hand over an object that stands on the table.
fn seen() -> Observation {
    let object = [-0.3, -0.1, scene::OBJECT_STANDING];
    Observation {
        angles: [0.0; JOINTS],
        palm: [-0.3, -0.1, object[2] + scene::OBJECT_RADIUS],
        palm_normal: [0.0, 0.0, -1.0],
        thumb_tip: object,
        little_tip: object,
        object,
        orientation: [1.0, 0.0, 0.0, 0.0],
        touch: [false; TOUCH_SENSORS],
    }
}

fn frame(observation: Observation, focus: f64, conditions: &[Condition]) -> Frame {
    let mut motors = Motors([0.5; MOTORS]);
    motors.0[0] = focus;
    let about_target = conditions.iter().any(|condition| condition.quantity == Quantity::ObjectToTarget);
    Frame {
        sensors: [0.0; SENSORS],
        heard: None,
        activity: Activity::default(),
        said: None,
        motors,
        observation,
        reward: 0.5,
        focused: motors.attends_target() == about_target,
        goal: conditions.iter().all(Condition::holds),
        conditions: conditions.to_vec(),
    }
}

fn condition(quantity: Quantity, value: f64, bound: Bound) -> Condition {
    Condition { quantity, value, bound }
}

fn failed(frames: Vec<Frame>) -> Trace {
    let steps = frames.len() as u32;
    let outcome = TrialOutcome { score: 0.5, success: false, steps };
    Trace { start: seen(), target: [-0.25, 0.1, 0.25], frames, outcome }
}

/// Why a trial failed in which the goal has to hold for three steps.
fn reason(behaviour: Behaviour, frames: Vec<Frame>) -> String {
    let mut experiment = Experiment::default();
    experiment.trials.hold = 3;
    Course::new(&experiment, behaviour, &failed(frames)).reason()
}

#[test]
fn a_palm_that_stays_away_is_said_to_and_in_which_direction() {
    let at = |x: f64, distance: f64, focus: f64| {
        let mut seen = seen();
        seen.palm[0] += x;
        frame(seen, focus, &[condition(Quantity::PalmToTop, distance, Bound::Below(0.06))])
    };
    let frames = vec![at(-0.2, 0.2, 0.1), at(-0.0834, 0.0834, 0.9), at(-0.1, 0.1, 0.9), at(-0.1, 0.1, 0.9)];
    assert_eq!(
        reason(Behaviour::Reach, frames),
        "nearest to the goal at step 2: palm to top 0.083 m (goal 0.06; 0.083 too far ahead); 0.100 m at the end; \
         focus on the object for 25 % of the trial"
    );
}

#[test]
fn of_several_conditions_those_that_lack_are_told_apart() {
    let at = |distance: f64, extension: f64, alignment: f64| {
        let conditions = [
            condition(Quantity::PalmToTop, distance, Bound::Below(0.06)),
            condition(Quantity::Extension, extension, Bound::Above(0.7)),
            condition(Quantity::Alignment, alignment, Bound::Above(0.85)),
        ];
        frame(seen(), 0.0, &conditions)
    };
    let frames = vec![at(0.05, 0.55, 0.9), at(0.2, 0.62, 0.9)];
    let trace = failed(frames.clone());
    let experiment = Experiment::default();
    let course = Course::new(&experiment, Behaviour::Open, &trace);
    assert_eq!((course.held(), course.focus(), course.lacking()), (0, 1.0, vec![Quantity::Extension]));
    assert_eq!(
        reason(Behaviour::Open, frames),
        "nearest to the goal at step 1: palm to top 0.050 m ok, extension 0.550 (goal 0.7), alignment 0.900 ok; \
         extension at best 0.620, step 2"
    );
    let apart = reason(Behaviour::Open, vec![at(0.05, 0.6, 0.9), at(0.2, 0.8, 0.9)]);
    assert!(apart.ends_with("each held at some step, but never together"), "{apart}");
    let lost = reason(Behaviour::Open, vec![at(0.05, 0.8, 0.9), at(0.05, 0.8, 0.9), at(0.05, 0.8, 0.8)]);
    assert_eq!(lost, "the goal held for 2 of 3 steps, until step 2, then alignment 0.800 (goal 0.85)");
    let late = reason(Behaviour::Open, vec![at(0.05, 0.8, 0.8), at(0.05, 0.8, 0.9)]);
    assert_eq!(late, "the goal held for 1 of 3 steps, until step 2, then the trial was over");
}

#[test]
fn an_object_that_is_pushed_away_is_said_to_be() {
    let conditions = [
        condition(Quantity::GripToObject, 0.03, Bound::Below(0.04)),
        condition(Quantity::Touches, 2.0, Bound::AtLeast(3.0)),
    ];
    let mut pushed = seen();
    pushed.object[0] -= 0.04;
    pushed.touch[0] = true;
    pushed.touch[2] = true;
    // On its side.
    pushed.orientation = [0.6, 0.8, 0.0, 0.0];
    assert_eq!(
        reason(Behaviour::Grasp, vec![frame(pushed, 0.0, &conditions)]),
        "nearest to the goal at step 1: grip to object 0.030 m ok, 2 of 3 touches; touched by palm, index; \
         object pushed 0.040 m away, object tipped over"
    );
}

#[test]
fn an_object_that_is_dropped_is_said_to_be() {
    let at = |height: f64, distance: f64, touch: bool| {
        let mut seen = seen();
        seen.object[2] += height;
        seen.touch[1] = touch;
        frame(seen, 1.0, &[condition(Quantity::ObjectToTarget, distance, Bound::Below(0.06))])
    };
    let frames = vec![at(0.1, 0.2, true), at(0.1, 0.1, true), at(0.05, 0.15, false), at(0.0, 0.2, false)];
    let text = reason(Behaviour::Move, frames.clone());
    assert!(text.contains("; object dropped at step 3; 0.200 m at the end"), "{text}");
    let text = reason(Behaviour::Move, frames[..3].to_vec());
    assert!(text.contains("object dropped at step 3, still falling at the end"), "{text}");
    assert!(!reason(Behaviour::Move, frames[..2].to_vec()).contains("dropped"));
}

#[test]
fn a_success_needs_no_reason_and_a_broken_simulation_has_one() {
    let holds = condition(Quantity::PalmToTop, 0.05, Bound::Below(0.06));
    let mut trace = failed(vec![frame(seen(), 0.0, &[holds])]);
    trace.outcome.success = true;
    let experiment = Experiment::default();
    assert_eq!(Course::new(&experiment, Behaviour::Reach, &trace).reason(), "");
    let mut broken = seen();
    broken.object[1] = f64::NAN;
    let lost = condition(Quantity::PalmToTop, f64::NAN, Bound::Below(0.06));
    let text = reason(Behaviour::Reach, vec![frame(broken, 0.0, &[lost])]);
    assert_eq!(text, "the simulation left the finite numbers in step 1");
}
