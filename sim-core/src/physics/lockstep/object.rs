//! The object: a ball with a flat base, one in each lane.

use fearless_simd::{Simd, SimdFloat};

use super::lanes::{Real, reciprocal, splat};
use super::spatial::{Rotation, Vec3, vec3};
use crate::scene;

/// State of the object: centre, orientation (w, x, y, z) and velocities.
#[derive(Clone, Copy)]
pub(super) struct Object<S: Simd> {
    pub(super) centre: Vec3<S>,
    pub(super) orientation: [Real<S>; 4],
    pub(super) twist: Twist<S>,
}

/// The object's velocities: its centre's, and the angular one.
#[derive(Clone, Copy)]
pub(super) struct Twist<S: Simd> {
    pub(super) linear: Vec3<S>,
    pub(super) angular: Vec3<S>,
}

impl<S: Simd> Twist<S> {
    #[inline(always)]
    pub(super) fn zero(simd: S) -> Self {
        Self { linear: Vec3::zero(simd), angular: Vec3::zero(simd) }
    }

    /// Velocity of the point of the object at `lever` from its centre.
    #[inline(always)]
    pub(super) fn at(&self, lever: Vec3<S>) -> Vec3<S> {
        self.linear + self.angular.cross(lever)
    }

    /// Takes an impulse that acts at `lever` from the centre.
    #[inline(always)]
    pub(super) fn push(&mut self, lever: Vec3<S>, impulse: Vec3<S>) {
        self.linear += impulse.scale(1.0 / scene::OBJECT_MASS);
        self.angular += lever.cross(impulse).scale(1.0 / scene::OBJECT_INERTIA);
    }
}

impl<S: Simd> Object<S> {
    pub(super) fn new(simd: S) -> Self {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        Self { centre: Vec3::zero(simd), orientation: [one, zero, zero, zero], twist: Twist::zero(simd) }
    }

    #[inline(always)]
    pub(super) fn rotation(&self) -> Rotation<S> {
        let [w, x, y, z] = self.orientation;
        let (x2, y2, z2) = (x + x, y + y, z + z);
        let (xx, yy, zz) = (x * x2, y * y2, z * z2);
        let (xy, xz, yz) = (x * y2, x * z2, y * z2);
        let (wx, wy, wz) = (w * x2, w * y2, w * z2);
        Rotation {
            x: vec3(-(yy + zz) + 1.0, xy + wz, xz - wy),
            y: vec3(xy - wz, -(xx + zz) + 1.0, yz + wx),
            z: vec3(xz + wy, yz - wx, -(xx + yy) + 1.0),
        }
    }

    /// Moves on with the present velocities.
    #[inline(always)]
    pub(super) fn drift(&mut self, simd: S, step: f64) {
        self.centre += self.twist.linear.scale(step);
        let [w, x, y, z] = self.orientation;
        let half = self.twist.angular.scale(0.5 * step);
        let moved = [
            w - (half.x * x + half.y * y + half.z * z),
            x + (half.x * w + half.y * z - half.z * y),
            y + (half.y * w + half.z * x - half.x * z),
            z + (half.z * w + half.x * y - half.y * x),
        ];
        let square = moved.iter().fold(splat(simd, 0.0), |sum, part| sum + *part * *part);
        let scale = reciprocal(simd, square.sqrt());
        self.orientation = moved.map(|part| part * scale);
    }
}
