//! The servos and stops of the joints, as rapier's implicit joint springs.

use crate::physics::{STOP_DAMPING, STOP_STIFFNESS};
use crate::robot::Joint;

/// Least stiffness of a spring, as a share of the servo's.
const SOFTEST: f64 = 1e-9;

/// The spring and damper that stand for servo and stop over a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Spring {
    /// N m / rad.
    pub(super) stiffness: f64,
    /// Angle at which it gives no torque, rad.
    pub(super) rest: f64,
    /// N m s / rad.
    pub(super) damping: f64,
}

impl Spring {
    /// The servo's torque is clamp(K (target - angle), limit) - D velocity; behind its limits a joint runs into a stiff
    /// damped spring. Which of this applies in a step of `step` seconds is decided at its beginning.
    pub(super) fn new(joint: &Joint, target: f64, angle: f64, velocity: f64, step: f64) -> Self {
        let pull = joint.stiffness * (target - angle);
        let ahead = pull - step * joint.stiffness * velocity;
        let limit = joint.torque_limit;
        let (mut torque, mut stiffness) =
            if ahead.abs() > limit { (limit.copysign(ahead), 0.0) } else { (pull, joint.stiffness) };
        let mut damping = joint.damping;
        let excess = angle - angle.clamp(joint.lower, joint.upper);
        if excess != 0.0 {
            let stop = STOP_STIFFNESS * joint.stiffness;
            torque -= stop * excess;
            stiffness += stop;
            damping += STOP_DAMPING * stop;
        }
        // A constant torque is the spring's that is nearly without stiffness, with its rest far away.
        let stiffness = stiffness.max(SOFTEST * joint.stiffness);
        Self { stiffness, rest: angle + torque / stiffness, damping }
    }
}
