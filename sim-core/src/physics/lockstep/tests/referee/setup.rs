//! The referee has the simulator's figures: from the URDF, and from what it is told beside it.

use serde::Deserialize;

use super::python::Python;
use crate::experiment::Physics;
use crate::robot::RobotModel;
use crate::scene;

const SETUP: &str = include_str!("../../../../../referee/setup.toml");

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Setup {
    table: f64,
    gravity: f64,
    friction: f64,
    palm: [f64; 3],
    object: Thing,
    servos: Vec<Servo>,
}

#[derive(Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Thing {
    radius: f64,
    base: f64,
    mass: f64,
    inertia: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Servo {
    prefix: String,
    stiffness: f64,
    armature: f64,
}

#[test]
fn the_referee_is_told_what_the_simulator_uses() {
    let setup: Setup = toml::from_str(SETUP).unwrap();
    let scene = [setup.table, setup.gravity, setup.friction];
    assert_eq!(scene, [scene::TABLE, scene::GRAVITY, Physics::default().friction]);
    let Thing { radius, base, mass, inertia } = setup.object;
    assert_eq!([radius, base, mass], [scene::OBJECT_RADIUS, scene::OBJECT_BASE, scene::OBJECT_MASS]);
    assert!((inertia / scene::OBJECT_INERTIA - 1.0).abs() < 1e-12);
    let robot = RobotModel::icub().unwrap();
    assert_eq!(setup.palm, <[f64; 3]>::from(robot.palm.point().coords));
    for joint in &robot.joints {
        let servo = setup.servos.iter().find(|servo| joint.name.starts_with(&servo.prefix)).unwrap();
        assert_eq!([servo.stiffness, servo.armature], [joint.stiffness, joint.armature], "{}", joint.name);
    }
}

/// What MuJoCo reads in the URDF.
#[derive(Deserialize)]
struct Urdf {
    names: Vec<String>,
    limits: Vec<[f64; 2]>,
    damping: Vec<f64>,
    torques: Vec<f64>,
    mass: f64,
}

#[test]
#[ignore = "asks MuJoCo: run `just referee`"]
fn mujoco_reads_the_shipped_urdf() {
    let robot = RobotModel::icub().unwrap();
    let urdf: Urdf = Python::start().ask("urdf", &());
    assert_eq!(urdf.names, robot.joints.each_ref().map(|joint| joint.name.clone()));
    assert_eq!(urdf.limits, robot.joints.each_ref().map(|joint| [joint.lower, joint.upper]));
    assert_eq!(urdf.damping, robot.joints.each_ref().map(|joint| joint.damping));
    assert_eq!(urdf.torques, robot.joints.each_ref().map(|joint| joint.torque_limit));
    let mass: f64 = robot.joints.iter().map(|joint| joint.body.mass).sum();
    assert!((urdf.mass - mass).abs() < 1e-12 * mass, "{} {mass}", urdf.mass);
}
