//! Finds the 16 initial postures and writes them as `assets/starts.toml`.
//!
//! All postures belong to one family: inverse kinematics from one preferred posture, found by random search for one
//! from which a scripted grasp lifts the object in all four areas. Each grasp is tried in the physics engine, with the
//! object moved a little and the fingers closed at once or slowly, and has to lift the object every time, between the
//! thumb and at least two other fingers or the palm. OPEN starts with the object under the palm, where it is enough to
//! stretch the fingers; GRASP where OPEN has come to its goal; MOVE when the closing fingers feel the object.
//!
//! Run from the repository's root, and look at the difference before keeping it:
//! `cargo run --release -p selftalk-sim --example make_starts > starts.toml && mv starts.toml sim-core/assets/`

use std::error::Error;
use std::ops::RangeInclusive;

use nalgebra::Point3;
use selftalk_sim::behaviours::{InHand, Start, Starts};
use selftalk_sim::experiment::Experiment;
use selftalk_sim::physics::{Engine, Instructions, Observation, Placement, engine};
use selftalk_sim::robot::{Capsule, HandGoal, JOINTS, Kinematics, RobotModel, joint};
use selftalk_sim::scene;

/// Torso and arm of the preferred posture, in radians.
const PREFERRED: [f64; 9] = [-0.0302, 0.2515, -1.4798, 2.0597, 0.7838, 1.1433, 0.9584, -0.2088, 0.2281];
/// Where the object's centre is in the hand's frame when the hand is over it, in metres.
const GRIP: [f64; 3] = [0.0913, -0.0619, 0.0398];
/// How the hand slopes when it is over the object, in radians.
const TILT: f64 = 0.1977;
const ROLL: f64 = 0.1491;
/// Opposition of the thumb as a share of its range: beside the object, and opposite the other fingers.
const ASIDE: f64 = 0.6541;
const OPPOSED: f64 = 0.6832;
/// How far all of the robot is from the object when the open hand is over it, in metres: more than the object is moved
/// in GRASP.
const CLEARANCE: f64 = 0.0055;

/// Flexion of the fingers as a share of their range: stretched, at rest, and closed; and of the stretched thumb.
const STRETCHED: f64 = 0.1933;
const AT_REST: f64 = 0.3;
const CLOSED: f64 = 0.9;
const THUMB_STRETCHED: f64 = 0.0000;

/// How far the object is moved from the grip's middle when a grasp is tried, in metres.
const SHIFTS: [[f64; 2]; 8] = [
    [0.0, 0.0],
    [0.006, 0.0],
    [-0.006, 0.0],
    [0.0, 0.006],
    [0.0, -0.006],
    [0.006, 0.006],
    [-0.006, -0.006],
    [0.006, -0.006],
];
/// Control steps in which the fingers' targets go from stretched to closed when a grasp is tried.
const CLOSING: [u32; 2] = [1, 10];

/// How high the object is lifted when a grasp is tried, in metres.
const LIFT: f64 = 0.08;
/// Touch sensors that feel the object at the start of MOVE: as many as the caretaker waits for before it says so.
const FELT: usize = 3;
/// Where the object's centre is in the hand's frame when the closed hand of OPEN is over it, in metres: under the palm,
/// whose point is 4.8 cm from its top, so that the fingers open beside it and do not sweep it away.
const UNDER_PALM: [f64; 3] = [0.05, -0.096, 0.012];
/// Where the hand's grip point is at the start of REACH, in metres: away from all areas.
const FAR: [[f64; 3]; 4] =
    [[-0.24, -0.26, 0.16], [-0.26, -0.27, 0.13], [-0.28, -0.24, 0.18], [-0.25, -0.25, 0.20]];

fn main() -> Result<(), Box<dyn Error>> {
    let robot = RobotModel::icub()?;
    let mut engine = engine(&robot, &Experiment::default(), Instructions::Best)?;
    let mut preferred = robot.joints.each_ref().map(|joint| joint.angle(AT_REST));
    preferred[joint::CARRIER].copy_from_slice(&PREFERRED);
    preferred[joint::THUMB_OPPOSITION] = robot.joints[joint::THUMB_OPPOSITION].angle(OPPOSED);
    let centre = bring(
        &robot,
        [scene::AREAS_CENTRE[0], scene::AREAS_CENTRE[1], scene::OBJECT_STANDING],
        0.0,
        0.0,
        &preferred,
    )
    .ok_or("the middle of the areas is out of reach")?;

    let (mut reach, mut open, mut grasp) = (Vec::new(), Vec::new(), Vec::new());
    let (mut transport, mut held) = (Vec::new(), Vec::new());
    for (direction, far) in scene::AREA_DIRECTIONS.iter().zip(FAR) {
        let object = [
            scene::AREAS_CENTRE[0] + direction[0] * scene::AREAS_DISTANCE,
            scene::AREAS_CENTRE[1] + direction[1] * scene::AREAS_DISTANCE,
            scene::OBJECT_STANDING,
        ];
        let Grasp { over, gripped, lifted } = grasp_and_lift(&robot, engine.as_mut(), object, &centre)
            .ok_or_else(|| format!("no grasp at {object:?}"))?;
        let above = most_level(&robot, UNDER_PALM, object, &over).ok_or("OPEN is out of reach")?;
        let away = slopes()
            .into_iter()
            .find_map(|[tilt, roll]| bring(&robot, far, tilt, roll, &centre))
            .ok_or_else(|| format!("REACH from {far:?} is out of reach"))?;
        reach.push(still(with_flexion(&robot, away, AT_REST)));
        open.push(still(with_flexion(&robot, above, CLOSED)));
        grasp.push(still(stretched(&robot, above)));
        transport.push(gripped);
        held.push(lifted);
    }
    let four = |starts: Vec<Start>| <[Start; 4]>::try_from(starts).map_err(|_| "four areas");
    let starts = Starts {
        reach: four(reach)?,
        open: four(open)?,
        grasp: four(grasp)?,
        transport: four(transport)?,
        held: four(held)?,
    };
    println!("# Initial postures, radians and metres. Made by the example make_starts, which says how.");
    println!(
        "# Joints in the order of the URDF: torso (2), shoulder (3), elbow, wrist (3), thumb (3), index, middle,"
    );
    println!("# ring, little finger (2 each).");
    print!("{}", toml::to_string(&starts)?);
    Ok(())
}

fn bring(
    robot: &RobotModel,
    at: [f64; 3],
    tilt: f64,
    roll: f64,
    start: &[f64; JOINTS],
) -> Option<[f64; JOINTS]> {
    let [x, y, z] = GRIP;
    let goal = HandGoal {
        point: Point3::new(x, y, z),
        position: Point3::from(at),
        tilt: TILT + tilt,
        roll: ROLL + roll,
    };
    robot.bring_hand(&goal, start)
}

/// Slopes of the hand to try, as differences from the preferred one, the smallest first.
fn slopes() -> Vec<[f64; 2]> {
    sorted(-4..=4, 0.15)
}

/// All pairs of multiples of a step, the smallest first.
fn sorted(multiples: RangeInclusive<i32>, step: f64) -> Vec<[f64; 2]> {
    let sides: Vec<f64> = multiples.map(|multiple| f64::from(multiple) * step).collect();
    let mut pairs: Vec<[f64; 2]> = sides.iter().flat_map(|a| sides.iter().map(|b| [*a, *b])).collect();
    let size = |s: &[f64; 2]| s[0] * s[0] + s[1] * s[1];
    pairs.sort_by(|a, b| size(a).total_cmp(&size(b)));
    pairs
}

/// The posture that brings a point of the hand somewhere with the palm as level as possible.
fn most_level(
    robot: &RobotModel,
    point: [f64; 3],
    at: [f64; 3],
    start: &[f64; JOINTS],
) -> Option<[f64; JOINTS]> {
    sorted(-28..=28, 0.025).into_iter().find_map(|[tilt, roll]| {
        let goal = HandGoal { point: Point3::from(point), position: Point3::from(at), tilt, roll };
        robot.bring_hand(&goal, start)
    })
}

fn with_flexion(robot: &RobotModel, mut angles: [f64; JOINTS], share: f64) -> [f64; JOINTS] {
    for i in joint::FLEXION {
        angles[i] = robot.joints[i].angle(share);
    }
    angles
}

/// Fingers and thumb stretched, the thumb aside.
fn stretched(robot: &RobotModel, angles: [f64; JOINTS]) -> [f64; JOINTS] {
    let mut angles = with_flexion(robot, angles, STRETCHED);
    for i in joint::THUMB_FLEXION {
        angles[i] = robot.joints[i].angle(THUMB_STRETCHED);
    }
    angles[joint::THUMB_OPPOSITION] = robot.joints[joint::THUMB_OPPOSITION].angle(ASIDE);
    angles
}

/// The smallest distance between the object's ball and the robot's capsules.
fn clearance(robot: &RobotModel, angles: &[f64; JOINTS], object: [f64; 3]) -> f64 {
    let links = Kinematics::new(robot, angles).links;
    let centre = Point3::from(object);
    let gap = |capsule: &Capsule| {
        capsule.distance(&(links[capsule.link].inverse() * centre)) - scene::OBJECT_RADIUS
    };
    robot.capsules.iter().map(gap).fold(f64::MAX, f64::min)
}

fn rounded<const N: usize>(values: [f64; N]) -> [f64; N] {
    values.map(|value| (value * 1e6).round() / 1e6)
}

fn still(angles: [f64; JOINTS]) -> Start {
    Start { angles: rounded(angles), in_hand: None }
}

/// A grasp that lifts the object.
struct Grasp {
    /// The open hand around the object.
    over: [f64; JOINTS],
    /// The state in which the closing fingers feel the object.
    gripped: Start,
    /// The state in which the object was lifted and is held.
    lifted: Start,
}

fn grasp_and_lift(
    robot: &RobotModel,
    engine: &mut dyn Engine,
    object: [f64; 3],
    centre: &[f64; JOINTS],
) -> Option<Grasp> {
    slopes().into_iter().find_map(|[tilt, roll]| {
        let [x, y, z] = object;
        let hand = bring(robot, object, tilt, roll, centre)?;
        let over = stretched(robot, hand);
        if clearance(robot, &over, object) < CLEARANCE {
            return None;
        }
        let lifted = with_flexion(robot, bring(robot, [x, y, z + LIFT], tilt, roll, &hand)?, CLOSED);
        let mut closed = with_flexion(robot, over, CLOSED);
        closed[joint::THUMB_OPPOSITION] = lifted[joint::THUMB_OPPOSITION];
        let mut seen = None;
        for shift in SHIFTS {
            for closing in CLOSING {
                let object = [x + shift[0], y + shift[1], z];
                let placement =
                    Placement { angles: over, targets: over, object, orientation: [1.0, 0.0, 0.0, 0.0] };
                engine.place(0, &placement);
                drive(engine, &over, &closed, closing);
                drive(engine, &closed, &closed, 30);
                drive(engine, &closed, &lifted, 40);
                drive(engine, &lifted, &lifted, 60);
                let now = engine.observe(0);
                let touches = now.touch.iter().filter(|touch| **touch).count();
                if (now.object[2] - z - LIFT).abs() > 0.02 || touches < 4 || !now.touch[1] {
                    return None;
                }
                seen.get_or_insert(now);
            }
        }
        let lifted = in_hand(&seen?, lifted);
        let gripped = gripped(engine, object, &over, &closed)?;
        Some(Grasp { over, gripped, lifted })
    })
}

/// Closes the hand around the object until enough sensors feel it.
fn gripped(
    engine: &mut dyn Engine,
    object: [f64; 3],
    over: &[f64; JOINTS],
    closed: &[f64; JOINTS],
) -> Option<Start> {
    let orientation = [1.0, 0.0, 0.0, 0.0];
    engine.place(0, &Placement { angles: *over, targets: *over, object, orientation });
    let steps = 40;
    for step in 1..=steps {
        let share = f64::from(step) / f64::from(steps);
        let targets = std::array::from_fn(|i| over[i] + share * (closed[i] - over[i]));
        engine.command(0, &targets);
        engine.advance();
        let seen = engine.observe(0);
        if seen.touch.iter().filter(|touch| **touch).count() >= FELT {
            return Some(in_hand(&seen, targets));
        }
    }
    None
}

/// A start in a state that was seen while the servos were commanded to targets.
fn in_hand(seen: &Observation, targets: [f64; JOINTS]) -> Start {
    let in_hand = InHand {
        object: rounded(seen.object),
        orientation: rounded(seen.orientation),
        targets: rounded(targets),
    };
    Start { angles: rounded(seen.angles), in_hand: Some(in_hand) }
}

/// Moves the servos' targets from one posture to another in `steps` control steps.
fn drive(engine: &mut dyn Engine, from: &[f64; JOINTS], to: &[f64; JOINTS], steps: u32) {
    for step in 1..=steps {
        let share = f64::from(step) / f64::from(steps);
        engine.command(0, &std::array::from_fn(|i| from[i] + share * (to[i] - from[i])));
        engine.advance();
    }
}
