//! How deep shapes overlap, from scalar kinematics and plain geometry.

#![allow(dead_code, reason = "each test uses a part of it")]

use nalgebra::{Point3, Vector3};
use selftalk_sim::physics::Observation;
use selftalk_sim::robot::{Kinematics, Part, RobotModel};
use selftalk_sim::scene;

/// Depths in metres; negative where there is a gap.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Overlap {
    /// Object and table.
    pub(crate) object_table: f64,
    /// Fingertips and forearm, and table.
    pub(crate) capsules_table: f64,
    /// Palm and table.
    pub(crate) palm_table: f64,
    /// Robot and object.
    pub(crate) robot_object: f64,
}

impl Overlap {
    /// What overlaps most.
    pub(crate) fn worst(&self) -> f64 {
        self.object_table.max(self.capsules_table).max(self.palm_table).max(self.robot_object)
    }

    /// The robot and the table.
    pub(crate) fn robot_table(&self) -> f64 {
        self.capsules_table.max(self.palm_table)
    }

    pub(crate) fn of(robot: &RobotModel, seen: &Observation) -> Self {
        let links = Kinematics::new(robot, &seen.angles).links;
        let centre = Point3::from(seen.object);
        let mut overlap = Self {
            object_table: scene::TABLE - (centre.z - lowest(seen)),
            capsules_table: f64::MIN,
            palm_table: f64::MIN,
            robot_object: f64::MIN,
        };
        for capsule in &robot.capsules {
            let [start, end] = [capsule.start, capsule.end].map(|end| links[capsule.link] * end);
            if !matches!(capsule.part, Part::Proximal(_)) {
                let depth = scene::TABLE - (start.z.min(end.z) - capsule.radius);
                overlap.capsules_table = overlap.capsules_table.max(depth);
            }
            let distance = capsule.distance(&(links[capsule.link].inverse() * centre));
            overlap.robot_object = overlap.robot_object.max(scene::OBJECT_RADIUS - distance);
        }
        let palm = links[robot.palm.link] * robot.palm.pose;
        for corner in 0..8_u8 {
            let side = |bit: u8| if corner >> bit & 1 == 0 { -1.0 } else { 1.0 };
            let local = robot.palm.half.component_mul(&Vector3::new(side(0), side(1), side(2)));
            overlap.palm_table = overlap.palm_table.max(scene::TABLE - (palm * Point3::from(local)).z);
        }
        let local = palm.inverse() * centre;
        let nearest = local.coords.zip_map(&robot.palm.half, |along, half| along.clamp(-half, half));
        let depth = scene::OBJECT_RADIUS - (nearest - local.coords).norm();
        overlap.robot_object = overlap.robot_object.max(depth);
        overlap
    }
}

/// How far below its centre the object, a ball cut flat, has its lowest point.
fn lowest(seen: &Observation) -> f64 {
    let upright = upright(seen);
    if upright < scene::OBJECT_BASE / scene::OBJECT_RADIUS {
        return scene::OBJECT_RADIUS;
    }
    let rim = (scene::OBJECT_RADIUS * scene::OBJECT_RADIUS - scene::OBJECT_BASE * scene::OBJECT_BASE).sqrt();
    scene::OBJECT_BASE * upright + rim * (1.0 - upright * upright).max(0.0).sqrt()
}

/// Cosine of the angle between the object's axis and straight up.
pub(crate) fn upright(seen: &Observation) -> f64 {
    let [_, x, y, _] = seen.orientation;
    1.0 - 2.0 * (x * x + y * y)
}
