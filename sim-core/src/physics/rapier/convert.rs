//! Between the project's mathematics (nalgebra) and rapier's (glam). Frames and units are the same on both sides.

use nalgebra::{Isometry3, Quaternion, Rotation3, SymmetricEigen, UnitQuaternion, Vector3};
use rapier3d_f64::prelude::{MassProperties, Pose, Rotation, Vector};

use crate::robot::Body;

pub(super) fn vector(v: &Vector3<f64>) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

pub(super) fn rotation(r: &UnitQuaternion<f64>) -> Rotation {
    Rotation::from_xyzw(r.i, r.j, r.k, r.w)
}

pub(super) fn pose(pose: &Isometry3<f64>) -> Pose {
    Pose { rotation: rotation(&pose.rotation), translation: vector(&pose.translation.vector) }
}

/// The pose as an isometry: a pose that left the finite numbers gives numbers that are not finite.
pub(super) fn isometry(pose: &Pose) -> Isometry3<f64> {
    let (t, r) = (pose.translation, pose.rotation);
    let rotation = UnitQuaternion::new_unchecked(Quaternion::new(r.w, r.x, r.y, r.z));
    Isometry3::from_parts(Vector3::new(t.x, t.y, t.z).into(), rotation)
}

/// Where something is that has left the finite numbers.
pub(super) fn nowhere() -> Isometry3<f64> {
    isometry(&Pose { rotation: Rotation::NAN, translation: Vector::NAN })
}

/// Mass, centre of mass and rotational inertia of a link, in its frame.
pub(super) fn mass(body: &Body) -> MassProperties {
    let principal = SymmetricEigen::new(body.inertia);
    let mut axes = principal.eigenvectors;
    if axes.determinant() < 0.0 {
        axes = -axes;
    }
    let frame = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
    MassProperties::with_principal_inertia_frame(
        vector(&body.centre.coords),
        body.mass,
        vector(&principal.eigenvalues),
        rotation(&frame),
    )
}
