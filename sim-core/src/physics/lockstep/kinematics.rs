//! Where all links are.

use fearless_simd::Simd;

use super::lanes::{Real, sin_cos};
use super::spatial::{Rotation, Vec3};
use super::tree::Tree;
use crate::robot::JOINTS;

/// Pose of a link in the root frame.
#[derive(Clone, Copy)]
pub(super) struct Pose<S: Simd> {
    pub(super) rotation: Rotation<S>,
    pub(super) position: Vec3<S>,
}

impl<S: Simd> Pose<S> {
    /// A point of the link's frame, in the root frame.
    #[inline(always)]
    pub(super) fn point(&self, p: &nalgebra::Vector3<f64>) -> Vec3<S> {
        self.position + self.rotation.turn(p)
    }
}

/// Forward kinematics: the poses of all links at the joint angles.
pub(super) fn forward<S: Simd>(
    simd: S,
    tree: &Tree,
    angles: &[Real<S>; JOINTS],
    poses: &mut [Pose<S>; JOINTS],
) {
    simd.vectorize(
        #[inline(always)]
        || {
            for (i, link) in tree.links.iter().enumerate() {
                let (base, position) = match link.parent.map(|parent| &poses[parent]) {
                    Some(parent) => {
                        let base = link.rotation.as_ref().map_or(parent.rotation, |rotation| Rotation {
                            x: parent.rotation.turn(&rotation.column(0).into_owned()),
                            y: parent.rotation.turn(&rotation.column(1).into_owned()),
                            z: parent.rotation.turn(&rotation.column(2).into_owned()),
                        });
                        (base, parent.point(&link.offset))
                    }
                    None => {
                        let base = link.rotation.unwrap_or_else(nalgebra::Matrix3::identity);
                        (Rotation::splat(simd, &base), Vec3::splat(simd, &link.offset))
                    }
                };
                let (s, c) = sin_cos(simd, angles[i]);
                let rotation = Rotation { x: base.x * c + base.y * s, y: base.y * c - base.x * s, z: base.z };
                poses[i] = Pose { rotation, position };
            }
        },
    );
}
