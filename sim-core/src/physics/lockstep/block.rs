//! A contact's three rows: how surfaces that touch respond to an impulse, and a Gauss-Seidel step on it.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask};

use super::contact::Contact;
use super::dynamics::Factor;
use super::lanes::{Mask, Real, max, min, reciprocal, splat};
use super::object::{Object, Twist};
use super::spatial::{Force, Vec3, vec3};
use super::tree::{Chain, MAX_FINGER, Tree};
use crate::physics::CORRECTION_SPEED;
use crate::robot::{JOINTS, joint};
use crate::scene;

/// Share of an overlap that is undone in a step ...
const CORRECTION: f64 = 0.2;
/// ... beyond this depth, in metres.
const SLOP: f64 = 0.0002;
/// Added to a contact's response, in 1/kg: keeps it invertible where the robot cannot move in some direction.
const COMPLIANCE: f64 = 1e-6;

/// What contacts act between.
pub(super) struct Bodies<'a, S: Simd> {
    pub(super) tree: &'a Tree,
    pub(super) factor: &'a Factor<S>,
    pub(super) object: &'a Object<S>,
}

/// The velocities that impulses change.
#[derive(Clone, Copy)]
pub(super) struct Velocities<S: Simd> {
    /// The robot's whitened joint velocities; see [`super::dynamics`].
    pub(super) robot: [Real<S>; JOINTS],
    pub(super) object: Twist<S>,
}

impl<S: Simd> Velocities<S> {
    #[inline(always)]
    pub(super) fn zero(simd: S) -> Self {
        Self { robot: [splat(simd, 0.0); JOINTS], object: Twist::zero(simd) }
    }

    /// Moves on along the conjugate direction, times `factor`, and finds the next direction, given the velocities
    /// before the last sweep.
    #[inline(always)]
    pub(super) fn move_on(&mut self, factor: Real<S>, conjugate: &mut Self, before: &Self) {
        for ((velocity, conjugate), before) in
            self.robot.iter_mut().zip(&mut conjugate.robot).zip(&before.robot)
        {
            let (change, step) = (*velocity - *before, *conjugate * factor);
            *velocity += step;
            *conjugate = step + change;
        }
        for (velocity, conjugate, before) in [
            (&mut self.object.linear, &mut conjugate.object.linear, before.object.linear),
            (&mut self.object.angular, &mut conjugate.object.angular, before.object.angular),
        ] {
            let (change, step) = (*velocity - before, *conjugate * factor);
            *velocity += step;
            *conjugate = step + change;
        }
    }
}

/// An impulse between two surfaces, N s.
#[derive(Clone, Copy)]
pub(super) struct Impulse<S: Simd> {
    pub(super) normal: Real<S>,
    /// Friction, in the root frame.
    pub(super) friction: Vec3<S>,
}

/// A contact's rows, ready for the sweeps.
pub(super) struct Block<S: Simd> {
    pub(super) candidate: usize,
    close: Mask<S>,
    /// Normal, then tangents.
    directions: [Vec3<S>; 3],
    /// The robot's joints in the contact, if it is in it.
    chain: Option<Chain>,
    /// Their entries of the three rows: torso and arm, then the finger.
    carrier: [[Real<S>; 3]; joint::CARRIER.end],
    finger: [[Real<S>; 3]; MAX_FINGER],
    /// How the object is in the contact, if it is.
    object: Option<Side>,
    /// From the object's centre to the contact.
    arm: Vec3<S>,
    /// Smallest normal velocity.
    bound: Real<S>,
    /// Responses of the rows to each other: normal-normal inverted, normal-tangents, inverse of the tangents' block.
    normal_inverse: Real<S>,
    coupling: [Real<S>; 2],
    inverse: [Real<S>; 3],
    /// Reciprocal of the tangents' mean response.
    yielding: Real<S>,
    /// Impulses so far, as in `directions`.
    impulse: [Real<S>; 3],
    /// What the last sweep added to them.
    change: [Real<S>; 3],
    /// The conjugate direction along which they move between sweeps.
    conjugate: [Real<S>; 3],
}

/// Which way the normal pushes the object.
#[derive(Clone, Copy)]
enum Side {
    /// The robot presses on it: against the normal.
    Pressed,
    /// The table supports it: along the normal.
    Supported,
}

impl Side {
    #[inline(always)]
    fn sign(self) -> f64 {
        match self {
            Self::Pressed => -1.0,
            Self::Supported => 1.0,
        }
    }
}

impl<S: Simd> Impulse<S> {
    pub(super) fn none(simd: S) -> Self {
        Self { normal: splat(simd, 0.0), friction: Vec3::zero(simd) }
    }
}

impl<S: Simd> Block<S> {
    pub(super) fn empty(simd: S) -> Self {
        let zero = splat(simd, 0.0);
        Self {
            candidate: 0,
            close: zero.simd_lt(0.0),
            directions: [Vec3::zero(simd); 3],
            chain: None,
            carrier: [[zero; 3]; joint::CARRIER.end],
            finger: [[zero; 3]; MAX_FINGER],
            object: None,
            arm: Vec3::zero(simd),
            bound: zero,
            normal_inverse: zero,
            coupling: [zero; 2],
            inverse: [zero; 3],
            yielding: zero,
            impulse: [zero; 3],
            change: [zero; 3],
            conjugate: [zero; 3],
        }
    }

    #[inline(always)]
    pub(super) fn prepare(
        &mut self,
        simd: S,
        &Bodies { tree, factor, object }: &Bodies<'_, S>,
        contact: &Contact<S>,
        last: &Impulse<S>,
        step: f64,
    ) {
        let zero = splat(simd, 0.0);
        self.candidate = contact.candidate;
        self.close = contact.close;
        self.directions = frame(simd, contact.normal);
        self.arm = contact.point - object.centre;
        self.object = match (contact.on_object, contact.link) {
            (true, Some(_)) => Some(Side::Pressed),
            (true, None) => Some(Side::Supported),
            (false, _) => None,
        };
        self.chain = contact.link.map(|link| tree.chains[link]);

        // Responses nn, ns, nt, ss, st, tt.
        let mut response =
            [splat(simd, COMPLIANCE), zero, zero, splat(simd, COMPLIANCE), zero, splat(simd, COMPLIANCE)];
        if let Some(chain) = self.chain {
            let mut forces = self.directions.map(
                #[inline(always)]
                |direction| Force::at(contact.point, direction),
            );
            for (entry, joint) in self.finger.iter_mut().zip(chain.finger().rev()) {
                *entry = factor.transmit_all(simd, joint, &mut forces);
                add_products::<S>(&mut response, *entry, *entry);
            }
            for joint in chain.carrier().rev() {
                let entry = factor.transmit_all(simd, joint, &mut forces);
                add_products::<S>(&mut response, entry, entry);
                self.carrier[joint] = entry;
            }
        }
        if self.object.is_some() {
            let [n, s, t] = self.directions;
            let turns = [self.arm.cross(n), self.arm.cross(s), self.arm.cross(t)];
            let rows = [
                [turns[0].x, turns[1].x, turns[2].x],
                [turns[0].y, turns[1].y, turns[2].y],
                [turns[0].z, turns[1].z, turns[2].z],
            ];
            for row in rows {
                let share = 1.0 / scene::OBJECT_INERTIA;
                add_products::<S>(&mut response, row, [row[0] * share, row[1] * share, row[2] * share]);
            }
            for own in [0, 3, 5] {
                response[own] += 1.0 / scene::OBJECT_MASS;
            }
        }
        let [nn, ns, nt, ss, st, tt] = response;
        let scale = reciprocal(simd, ss * tt - st * st);
        self.normal_inverse = reciprocal(simd, nn);
        self.coupling = [ns, nt];
        self.inverse = [tt * scale, -st * scale, ss * scale];
        self.yielding = splat(simd, 2.0) / (ss + tt);

        // Apart, the surfaces may close the gap in one step; overlapping, they separate at a bounded speed.
        let apart = contact.gap * (-1.0 / step);
        let deep = (contact.gap + SLOP) * (-CORRECTION / step);
        let push = min(simd, max(simd, deep, zero), splat(simd, CORRECTION_SPEED));
        self.bound = contact.gap.simd_gt(0.0).select(apart, push);
        let begin =
            [last.normal, last.friction.dot(self.directions[1]), last.friction.dot(self.directions[2])];
        self.conjugate = [zero; 3];
        self.impulse = begin.map(
            #[inline(always)]
            |impulse| contact.close.select(impulse, zero),
        );
    }

    /// Applies the impulses of the last step.
    #[inline(always)]
    pub(super) fn begin(&self, velocities: &mut Velocities<S>) {
        self.apply(self.impulse, velocities);
    }

    /// The impulse as it stands.
    #[inline(always)]
    pub(super) fn impulse(&self) -> Impulse<S> {
        let [normal, s, t] = self.impulse;
        Impulse { normal, friction: self.directions[1] * s + self.directions[2] * t }
    }

    /// Improves the impulses of the lanes that go on; returns the square of their change.
    #[inline(always)]
    pub(super) fn sweep(
        &mut self,
        simd: S,
        friction: f64,
        moving: Mask<S>,
        velocities: &mut Velocities<S>,
    ) -> Real<S> {
        let zero = splat(simd, 0.0);
        let active = self.close & moving;
        if !active.any_true() {
            self.change = [zero; 3];
            return zero;
        }
        let [vn, vs, vt] = self.velocity(simd, velocities);
        let [n, s, t] = self.impulse;
        // Friction at its limit grows with the normal impulse. Where it lifts the contact, it does a part of the work.
        let lift = max(simd, self.coupling[0] * s + self.coupling[1] * t, zero) * self.normal_inverse;
        let share = n.simd_gt(0.0).select(n / (n + lift), splat(simd, 1.0));
        let normal = max(simd, n + (self.bound - vn) * self.normal_inverse * share, zero);
        let dn = active.select(normal - n, zero);
        let (vs, vt) = (vs + self.coupling[0] * dn, vt + self.coupling[1] * dn);
        let limit = (n + dn) * friction;
        // Sticking: what stops both tangents.
        let [a, b, c] = self.inverse;
        let mut held = [s - (a * vs + b * vt), t - (b * vs + c * vt)];
        let slides = (held[0] * held[0] + held[1] * held[1]).simd_gt(limit * limit);
        if (slides & active).any_true() {
            // Sliding: along the motion, however unequally the tangents respond.
            let slid = [s - vs * self.yielding, t - vt * self.yielding];
            let square = slid[0] * slid[0] + slid[1] * slid[1];
            let scale = square.simd_gt(limit * limit).select(limit / square.sqrt(), splat(simd, 1.0));
            held = [slides.select(slid[0] * scale, held[0]), slides.select(slid[1] * scale, held[1])];
        }
        let ds = active.select(held[0] - s, zero);
        let dt = active.select(held[1] - t, zero);
        self.impulse = [n + dn, s + ds, t + dt];
        self.change = [dn, ds, dt];
        self.apply([dn, ds, dt], velocities);
        dn * dn + ds * ds + dt * dt
    }

    /// Moves the impulses on along the conjugate direction, times `factor`, and finds the next direction. What that
    /// does to the velocities is the same for all blocks together: [`Velocities::move_on`].
    #[inline(always)]
    pub(super) fn move_on(&mut self, factor: Real<S>) {
        let parts = self.impulse.iter_mut().zip(&mut self.conjugate).zip(&self.change);
        for ((impulse, conjugate), change) in parts {
            let step = *conjugate * factor;
            *impulse += step;
            *conjugate = step + *change;
        }
    }

    /// Velocity of the surfaces relative to each other, along the directions.
    #[inline(always)]
    fn velocity(&self, simd: S, velocities: &Velocities<S>) -> [Real<S>; 3] {
        let mut sum = [splat(simd, 0.0); 3];
        if let Some(chain) = &self.chain {
            for (entry, w) in self.carrier.iter().zip(&velocities.robot[chain.carrier()]) {
                add_multiple::<S>(&mut sum, entry, *w);
            }
            for (entry, w) in self.finger.iter().zip(velocities.robot[chain.finger()].iter().rev()) {
                add_multiple::<S>(&mut sum, entry, *w);
            }
        }
        if let Some(side) = self.object {
            let velocity = velocities.object.at(self.arm).scale(side.sign());
            for (sum, direction) in sum.iter_mut().zip(&self.directions) {
                *sum += direction.dot(velocity);
            }
        }
        sum
    }

    #[inline(always)]
    fn apply(&self, [a, b, c]: [Real<S>; 3], velocities: &mut Velocities<S>) {
        if let Some(chain) = &self.chain {
            for (entry, w) in self.carrier.iter().zip(&mut velocities.robot[chain.carrier()]) {
                *w += entry[0] * a + entry[1] * b + entry[2] * c;
            }
            for (entry, w) in self.finger.iter().zip(velocities.robot[chain.finger()].iter_mut().rev()) {
                *w += entry[0] * a + entry[1] * b + entry[2] * c;
            }
        }
        if let Some(side) = self.object {
            let [n, s, t] = self.directions;
            velocities.object.push(self.arm, (n * a + s * b + t * c).scale(side.sign()));
        }
    }
}

#[inline(always)]
fn add_multiple<S: Simd>(sums: &mut [Real<S>; 3], entry: &[Real<S>; 3], factor: Real<S>) {
    sums[0] += entry[0] * factor;
    sums[1] += entry[1] * factor;
    sums[2] += entry[2] * factor;
}

/// Adds the products of three numbers with three others: 00, 01, 02, 11, 12, 22.
#[inline(always)]
fn add_products<S: Simd>(sums: &mut [Real<S>; 6], a: [Real<S>; 3], b: [Real<S>; 3]) {
    sums[0] += a[0] * b[0];
    sums[1] += a[0] * b[1];
    sums[2] += a[0] * b[2];
    sums[3] += a[1] * b[1];
    sums[4] += a[1] * b[2];
    sums[5] += a[2] * b[2];
}

/// A normal with two tangents (Duff et al., Building an Orthonormal Basis, Revisited, 2017).
#[inline(always)]
fn frame<S: Simd>(simd: S, n: Vec3<S>) -> [Vec3<S>; 3] {
    let sign = n.z.simd_lt(0.0).select(splat(simd, -1.0), splat(simd, 1.0));
    let a = splat(simd, -1.0) / (sign + n.z);
    let b = n.x * n.y * a;
    let first = vec3(sign * n.x * n.x * a + 1.0, sign * b, -sign * n.x);
    let second = vec3(b, n.y * n.y * a + sign, -n.y);
    [n, first, second]
}
