//! Vectors, spatial vectors and inertias, one for each lane.
//!
//! Spatial vectors are Featherstone's (Rigid Body Dynamics Algorithms, 2008), all about the origin of the root frame
//! and along its axes, so that those of different links add up without a transform.

use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

use fearless_simd::{Simd, SimdFloat};
use nalgebra::{Matrix3, Vector3};

use super::lanes::{Real, splat};

/// A vector in the root frame.
#[derive(Clone, Copy)]
pub(super) struct Vec3<S: Simd> {
    pub(super) x: Real<S>,
    pub(super) y: Real<S>,
    pub(super) z: Real<S>,
}

#[inline(always)]
pub(super) fn vec3<S: Simd>(x: Real<S>, y: Real<S>, z: Real<S>) -> Vec3<S> {
    Vec3 { x, y, z }
}

impl<S: Simd> Vec3<S> {
    #[inline(always)]
    pub(super) fn splat(simd: S, v: &Vector3<f64>) -> Self {
        vec3(splat(simd, v.x), splat(simd, v.y), splat(simd, v.z))
    }

    #[inline(always)]
    pub(super) fn zero(simd: S) -> Self {
        let zero = splat(simd, 0.0);
        vec3(zero, zero, zero)
    }

    /// The vector times a number that is the same in all lanes.
    #[inline(always)]
    pub(super) fn scale(self, s: f64) -> Self {
        vec3(self.x * s, self.y * s, self.z * s)
    }

    #[inline(always)]
    pub(super) fn dot(self, o: Self) -> Real<S> {
        self.x * o.x + self.y * o.y + self.z * o.z
    }

    #[inline(always)]
    pub(super) fn cross(self, o: Self) -> Self {
        vec3(self.y * o.z - self.z * o.y, self.z * o.x - self.x * o.z, self.x * o.y - self.y * o.x)
    }

    #[inline(always)]
    pub(super) fn norm(self) -> Real<S> {
        self.dot(self).sqrt()
    }
}

impl<S: Simd> Add for Vec3<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        vec3(self.x + o.x, self.y + o.y, self.z + o.z)
    }
}

impl<S: Simd> AddAssign for Vec3<S> {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl<S: Simd> Sub for Vec3<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        vec3(self.x - o.x, self.y - o.y, self.z - o.z)
    }
}

impl<S: Simd> SubAssign for Vec3<S> {
    #[inline(always)]
    fn sub_assign(&mut self, o: Self) {
        *self = *self - o;
    }
}

impl<S: Simd> Neg for Vec3<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        vec3(-self.x, -self.y, -self.z)
    }
}

impl<S: Simd> Mul<Real<S>> for Vec3<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: Real<S>) -> Self {
        vec3(self.x * s, self.y * s, self.z * s)
    }
}

/// A rotation matrix by its columns: the axes of the rotated frame.
#[derive(Clone, Copy)]
pub(super) struct Rotation<S: Simd> {
    pub(super) x: Vec3<S>,
    pub(super) y: Vec3<S>,
    pub(super) z: Vec3<S>,
}

impl<S: Simd> Rotation<S> {
    #[inline(always)]
    pub(super) fn splat(simd: S, m: &Matrix3<f64>) -> Self {
        Self {
            x: Vec3::splat(simd, &m.column(0).into_owned()),
            y: Vec3::splat(simd, &m.column(1).into_owned()),
            z: Vec3::splat(simd, &m.column(2).into_owned()),
        }
    }

    /// A vector of the rotated frame, in the outer frame; the same for all lanes.
    #[inline(always)]
    pub(super) fn turn(&self, v: &Vector3<f64>) -> Vec3<S> {
        self.x.scale(v.x) + self.y.scale(v.y) + self.z.scale(v.z)
    }

    /// A vector of the outer frame, in the rotated frame.
    #[inline(always)]
    pub(super) fn turn_back(&self, v: Vec3<S>) -> Vec3<S> {
        vec3(self.x.dot(v), self.y.dot(v), self.z.dot(v))
    }
}

/// A motion vector: angular velocity, and linear velocity of the point at the origin.
#[derive(Clone, Copy)]
pub(super) struct Motion<S: Simd> {
    pub(super) angular: Vec3<S>,
    pub(super) linear: Vec3<S>,
}

impl<S: Simd> Motion<S> {
    #[inline(always)]
    pub(super) fn zero(simd: S) -> Self {
        Self { angular: Vec3::zero(simd), linear: Vec3::zero(simd) }
    }

    /// Rotation about the line through `point` along `axis`.
    #[inline(always)]
    pub(super) fn revolution(axis: Vec3<S>, point: Vec3<S>) -> Self {
        Self { angular: axis, linear: point.cross(axis) }
    }

    /// Power of a force.
    #[inline(always)]
    pub(super) fn dot(&self, f: &Force<S>) -> Real<S> {
        self.angular.dot(f.moment) + self.linear.dot(f.linear)
    }

    /// The derivative of a motion vector that moves with this motion (Featherstone's v x m).
    #[inline(always)]
    pub(super) fn cross(&self, m: &Self) -> Self {
        Self {
            angular: self.angular.cross(m.angular),
            linear: self.angular.cross(m.linear) + self.linear.cross(m.angular),
        }
    }

    /// The derivative of a force vector that moves with this motion (Featherstone's v x* f).
    #[inline(always)]
    pub(super) fn cross_force(&self, f: &Force<S>) -> Force<S> {
        Force {
            moment: self.angular.cross(f.moment) + self.linear.cross(f.linear),
            linear: self.angular.cross(f.linear),
        }
    }

    #[inline(always)]
    pub(super) fn scale_add(&self, m: &Self, s: Real<S>) -> Self {
        Self { angular: self.angular + m.angular * s, linear: self.linear + m.linear * s }
    }
}

impl<S: Simd> Add for Motion<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self { angular: self.angular + o.angular, linear: self.linear + o.linear }
    }
}

/// A force vector, momentum or impulse: moment about the origin, and linear force.
#[derive(Clone, Copy)]
pub(super) struct Force<S: Simd> {
    pub(super) moment: Vec3<S>,
    pub(super) linear: Vec3<S>,
}

impl<S: Simd> Force<S> {
    #[inline(always)]
    pub(super) fn zero(simd: S) -> Self {
        Self { moment: Vec3::zero(simd), linear: Vec3::zero(simd) }
    }

    /// A force along `direction` that acts at `point`.
    #[inline(always)]
    pub(super) fn at(point: Vec3<S>, direction: Vec3<S>) -> Self {
        Self { moment: point.cross(direction), linear: direction }
    }

    #[inline(always)]
    pub(super) fn scale(&self, s: Real<S>) -> Self {
        Self { moment: self.moment * s, linear: self.linear * s }
    }
}

impl<S: Simd> Add for Force<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self { moment: self.moment + o.moment, linear: self.linear + o.linear }
    }
}

impl<S: Simd> Sub for Force<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self { moment: self.moment - o.moment, linear: self.linear - o.linear }
    }
}

/// A symmetric 3 x 3 matrix.
#[derive(Clone, Copy)]
pub(super) struct Symmetric<S: Simd> {
    pub(super) xx: Real<S>,
    pub(super) yy: Real<S>,
    pub(super) zz: Real<S>,
    pub(super) xy: Real<S>,
    pub(super) xz: Real<S>,
    pub(super) yz: Real<S>,
}

impl<S: Simd> Symmetric<S> {
    #[inline(always)]
    pub(super) fn isotropic(simd: S, value: Real<S>) -> Self {
        let zero = splat(simd, 0.0);
        Self { xx: value, yy: value, zz: value, xy: zero, xz: zero, yz: zero }
    }

    #[inline(always)]
    pub(super) fn times(&self, v: Vec3<S>) -> Vec3<S> {
        vec3(
            self.xx * v.x + self.xy * v.y + self.xz * v.z,
            self.xy * v.x + self.yy * v.y + self.yz * v.z,
            self.xz * v.x + self.yz * v.y + self.zz * v.z,
        )
    }

    /// Adds `s v vᵀ`, given `v` and `w = s v`.
    #[inline(always)]
    pub(super) fn add_outer(&mut self, v: Vec3<S>, w: Vec3<S>) {
        self.xx += v.x * w.x;
        self.yy += v.y * w.y;
        self.zz += v.z * w.z;
        self.xy += v.x * w.y;
        self.xz += v.x * w.z;
        self.yz += v.y * w.z;
    }
}

impl<S: Simd> Add for Symmetric<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self {
            xx: self.xx + o.xx,
            yy: self.yy + o.yy,
            zz: self.zz + o.zz,
            xy: self.xy + o.xy,
            xz: self.xz + o.xz,
            yz: self.yz + o.yz,
        }
    }
}

/// The inertia of a rigid body: mass, centre of mass and rotational inertia about it.
#[derive(Clone, Copy)]
pub(super) struct RigidInertia<S: Simd> {
    pub(super) mass: f64,
    pub(super) centre: Vec3<S>,
    pub(super) rotational: Symmetric<S>,
}

impl<S: Simd> RigidInertia<S> {
    /// The momentum at a velocity, or the force for an acceleration.
    #[inline(always)]
    pub(super) fn times(&self, v: &Motion<S>) -> Force<S> {
        let linear = (v.linear + v.angular.cross(self.centre)).scale(self.mass);
        Force { moment: self.rotational.times(v.angular) + self.centre.cross(linear), linear }
    }
}

/// An articulated-body inertia: the symmetric 6 x 6 matrix [[I, H], [Hᵀ, M]] from motion to force.
#[derive(Clone, Copy)]
pub(super) struct ArticulatedInertia<S: Simd> {
    /// I: moment for angular acceleration.
    rotational: Symmetric<S>,
    /// H by its rows: moment for linear acceleration.
    coupling: [Vec3<S>; 3],
    /// M: force for linear acceleration.
    linear: Symmetric<S>,
}

impl<S: Simd> ArticulatedInertia<S> {
    #[inline(always)]
    pub(super) fn zero(simd: S) -> Self {
        let zero = Symmetric::isotropic(simd, splat(simd, 0.0));
        Self { rotational: zero, coupling: [Vec3::zero(simd); 3], linear: zero }
    }

    #[inline(always)]
    pub(super) fn rigid(simd: S, body: &RigidInertia<S>) -> Self {
        let zero = splat(simd, 0.0);
        let (c, first_moment) = (body.centre, body.centre.scale(body.mass));
        let mut rotational = body.rotational + Symmetric::isotropic(simd, c.dot(first_moment));
        rotational.add_outer(c, -first_moment);
        let m = first_moment;
        Self {
            rotational,
            coupling: [vec3(zero, -m.z, m.y), vec3(m.z, zero, -m.x), vec3(-m.y, m.x, zero)],
            linear: Symmetric::isotropic(simd, splat(simd, body.mass)),
        }
    }

    #[inline(always)]
    pub(super) fn times(&self, v: &Motion<S>) -> Force<S> {
        let [a, b, c] = self.coupling;
        let (w, l) = (v.angular, v.linear);
        Force {
            moment: self.rotational.times(w) + vec3(a.dot(l), b.dot(l), c.dot(l)),
            linear: a * w.x + b * w.y + c * w.z + self.linear.times(l),
        }
    }

    /// Subtracts `f fᵀ`.
    #[inline(always)]
    pub(super) fn subtract_outer(&mut self, f: &Force<S>) {
        let (n, l) = (f.moment, f.linear);
        self.rotational.add_outer(n, -n);
        self.coupling[0] -= l * n.x;
        self.coupling[1] -= l * n.y;
        self.coupling[2] -= l * n.z;
        self.linear.add_outer(l, -l);
    }
}

impl<S: Simd> Add for ArticulatedInertia<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        let [a, b, c] = self.coupling;
        let [d, e, f] = o.coupling;
        Self {
            rotational: self.rotational + o.rotational,
            coupling: [a + d, b + e, c + f],
            linear: self.linear + o.linear,
        }
    }
}
