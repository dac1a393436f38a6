//! The robot's equation of motion: articulated-body inertias (Featherstone 2008, chapter 7), with the servos taken
//! implicitly.
//!
//! With A = M + h D + h² K, the joint-space inertia M (armature included) plus what servo damping D and stiffness K
//! add over a step h, the sweep from the fingertips to the torso gives a factor A = Lᵀ L without forming either. The
//! velocities v then appear as w = L v: a contact's row J becomes r = L⁻ᵀ Jᵀ, its velocity is r·w, an impulse p adds
//! p r to w, and the responses of two contacts to each other are dot products of their rows.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat};

use super::kinematics::Pose;
use super::lanes::{Real, reciprocal, splat};
use super::spatial::{ArticulatedInertia, Force, Motion, RigidInertia, Symmetric};
use super::tree::{Mass, Servo, Tree};
use crate::physics::{STOP_DAMPING, STOP_STIFFNESS};
use crate::robot::JOINTS;

/// The factor of A, link by link.
pub(super) struct Factor<S: Simd> {
    /// Joint axes as motion vectors.
    pub(super) axes: [Motion<S>; JOINTS],
    /// Articulated-body inertia times axis, over the root of the joint's inertia.
    forces: [Force<S>; JOINTS],
    /// Reciprocal root of the inertia that the joint sees.
    scales: [Real<S>; JOINTS],
    /// What the sweep works on: each link's inertia and momentum with its descendants'.
    inertias: [ArticulatedInertia<S>; JOINTS],
    momenta: [Force<S>; JOINTS],
    /// Each link's velocity.
    pub(super) velocities: [Motion<S>; JOINTS],
    /// Each link's acceleration that the velocities alone cause.
    accelerations: [Motion<S>; JOINTS],
}

impl<S: Simd> Factor<S> {
    pub(super) fn new(simd: S) -> Self {
        Self {
            axes: [Motion::zero(simd); JOINTS],
            forces: [Force::zero(simd); JOINTS],
            scales: [splat(simd, 0.0); JOINTS],
            inertias: [ArticulatedInertia::zero(simd); JOINTS],
            momenta: [Force::zero(simd); JOINTS],
            velocities: [Motion::zero(simd); JOINTS],
            accelerations: [Motion::zero(simd); JOINTS],
        }
    }

    /// Takes a force on a link through joint `i`: returns the joint's entry of L⁻ᵀ Jᵀ and leaves in `force` what
    /// acts on the parent.
    #[inline(always)]
    pub(super) fn transmit(&self, i: usize, force: &mut Force<S>, joint: Real<S>) -> Real<S> {
        let entry = (self.axes[i].dot(force) + joint) * self.scales[i];
        *force = *force - self.forces[i].scale(entry);
        entry
    }

    /// The same for three forces at once.
    #[inline(always)]
    pub(super) fn transmit_all(&self, simd: S, i: usize, forces: &mut [Force<S>; 3]) -> [Real<S>; 3] {
        let zero = splat(simd, 0.0);
        let [a, b, c] = forces;
        [self.transmit(i, a, zero), self.transmit(i, b, zero), self.transmit(i, c, zero)]
    }
}

/// Factors A at the present posture and returns w after a step without contacts in `whitened`.
pub(super) fn smooth<S: Simd>(
    simd: S,
    tree: &Tree,
    poses: &[Pose<S>; JOINTS],
    state: &Joints<S>,
    step: f64,
    factor: &mut Factor<S>,
    whitened: &mut [Real<S>; JOINTS],
) {
    simd.vectorize(
        #[inline(always)]
        || {
            for (i, link) in tree.links.iter().enumerate() {
                let axis = Motion::revolution(poses[i].rotation.z, poses[i].position);
                let (velocity, acceleration) = match link.parent {
                    Some(parent) => (factor.velocities[parent], factor.accelerations[parent]),
                    None => (Motion::zero(simd), Motion::zero(simd)),
                };
                let velocity = velocity.scale_add(&axis, state.velocities[i]);
                let acceleration = acceleration.scale_add(&velocity.cross(&axis), state.velocities[i]);
                factor.velocities[i] = velocity;
                factor.accelerations[i] = acceleration;
                factor.axes[i] = axis;
                let body = turned(simd, &link.mass, &poses[i]);
                let momentum = body.times(&velocity);
                let bias = body.times(&acceleration) + velocity.cross_force(&momentum);
                factor.momenta[i] = momentum - bias.scale(splat(simd, step));
                factor.inertias[i] = ArticulatedInertia::rigid(simd, &body);
            }
            for (i, link) in tree.links.iter().enumerate().rev() {
                let (drive, added) = servo(simd, &link.servo, state, i, step);
                let force = factor.inertias[i].times(&factor.axes[i]);
                let seen = factor.axes[i].dot(&force) + (added + link.servo.armature);
                let scale = reciprocal(simd, seen.sqrt());
                factor.scales[i] = scale;
                factor.forces[i] = force.scale(scale);
                let joint = state.velocities[i] * link.servo.armature + drive;
                let mut momentum = factor.momenta[i];
                whitened[i] = factor.transmit(i, &mut momentum, joint);
                if let Some(parent) = link.parent {
                    let mut inertia = factor.inertias[i];
                    inertia.subtract_outer(&factor.forces[i]);
                    factor.inertias[parent] = factor.inertias[parent] + inertia;
                    factor.momenta[parent] = factor.momenta[parent] + momentum;
                }
            }
        },
    );
}

/// Recovers the joint velocities from w: v = L⁻¹ w.
pub(super) fn recover<S: Simd>(
    simd: S,
    tree: &Tree,
    factor: &mut Factor<S>,
    whitened: &[Real<S>; JOINTS],
    velocities: &mut [Real<S>; JOINTS],
) {
    simd.vectorize(
        #[inline(always)]
        || {
            for (i, link) in tree.links.iter().enumerate() {
                let parent = link.parent.map_or(Motion::zero(simd), |parent| factor.velocities[parent]);
                velocities[i] = (whitened[i] - parent.dot(&factor.forces[i])) * factor.scales[i];
                factor.velocities[i] = parent.scale_add(&factor.axes[i], velocities[i]);
            }
        },
    );
}

/// State of the joints.
pub(super) struct Joints<S: Simd> {
    pub(super) angles: [Real<S>; JOINTS],
    pub(super) velocities: [Real<S>; JOINTS],
    pub(super) targets: [Real<S>; JOINTS],
}

/// A joint's servo and stops over a step: the angular impulse they give a joint that stands still, and what they add
/// to the joint's inertia.
///
/// The servo's torque is clamp(K (target - angle), limit) - D velocity, at the end of the step; its weight is
/// compensated, so gravity does not appear. Behind its limits a joint runs into a stiff damped spring.
#[inline(always)]
fn servo<S: Simd>(simd: S, servo: &Servo, state: &Joints<S>, i: usize, step: f64) -> (Real<S>, Real<S>) {
    let (angle, velocity) = (state.angles[i], state.velocities[i]);
    let limit = splat(simd, servo.torque_limit);
    let now = (state.targets[i] - angle) * servo.stiffness;
    let ahead = now - velocity * (step * servo.stiffness);
    let (high, low) = (ahead.simd_gt(limit), ahead.simd_lt(-limit));
    let zero = splat(simd, 0.0);
    let torque = high.select(limit, low.select(-limit, now));
    let soft = (high | low).select(zero, splat(simd, step * step * servo.stiffness));

    let below = angle.simd_lt(servo.lower);
    let above = angle.simd_gt(servo.upper);
    let excess = below.select(-angle + servo.lower, above.select(-angle + servo.upper, zero));
    let stiffness = servo.stiffness * STOP_STIFFNESS;
    let stop = splat(simd, step * (STOP_DAMPING + step) * stiffness);
    let added = soft + (below | above).select(stop, zero) + step * servo.damping;
    ((torque + excess * stiffness) * step, added)
}

#[inline(always)]
fn turned<S: Simd>(simd: S, mass: &Mass, pose: &Pose<S>) -> RigidInertia<S> {
    let mut rotational = Symmetric::isotropic(simd, splat(simd, mass.round));
    for (excess, axis) in &mass.excess {
        let axis = pose.rotation.turn(axis);
        rotational.add_outer(axis, axis.scale(*excess));
    }
    RigidInertia { mass: mass.mass, centre: pose.point(&mass.centre), rotational }
}
