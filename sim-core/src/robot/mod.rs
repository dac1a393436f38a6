//! The robot: torso, left arm and left hand of the iCub as a tree of 20 moving links.
//!
//! Frames: the root frame lies at the waist, x backward, y to the robot's right, z up. A link's frame is its URDF
//! frame, with the origin on its joint's axis. Lengths in metres, angles in radians, masses in kilograms.

mod ik;
mod kinematics;
mod model;
mod urdf;

pub use ik::HandGoal;
pub use kinematics::Kinematics;
pub use model::{Body, Capsule, JOINTS, Joint, Palm, Part, RobotError, RobotModel};

/// Indices of the joints, in the order of the chain.
pub mod joint {
    use std::ops::Range;

    /// Torso: extension and flexion.
    pub const TORSO_PITCH: usize = 0;
    /// Torso: rotation.
    pub const TORSO_YAW: usize = 1;
    /// Shoulder (3), elbow, wrist (3).
    pub const ARM: Range<usize> = 2..9;
    /// Torso and arm: the joints that carry the hand.
    pub const CARRIER: Range<usize> = 0..9;
    /// Opposition of the thumb to the other fingers.
    pub const THUMB_OPPOSITION: usize = 9;
    /// Flexion of the thumb.
    pub const THUMB_FLEXION: Range<usize> = 10..12;
    /// Flexion of index, middle, ring and little finger, two joints each.
    pub const FINGER_FLEXION: Range<usize> = 12..20;
    /// Flexion of all five fingers.
    pub const FLEXION: Range<usize> = 10..20;
    /// The link that is the hand: the last of the carrier.
    pub const HAND: usize = 8;
    /// The link that is the forearm.
    pub const FOREARM: usize = 6;
}
