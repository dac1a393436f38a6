//! Table and object in rapier. For the robot the object is a ball. For the table it is that ball where it is round, and
//! a disc where it was cut flat.

use nalgebra::Unit;
use rapier3d_f64::prelude::{
    ActiveHooks, ColliderBuilder, ColliderHandle, ColliderSet, MassProperties, PairFilterContext,
    PhysicsHooks, Pose, RigidBodyBuilder, RigidBodyHandle, RigidBodySet, Rotation, SolverFlags, Vector,
};

use super::contact::Role;
use crate::scene;

/// Where table and object are found in a world.
#[derive(Debug, Clone, Copy)]
pub(super) struct Objects {
    pub(super) table: ColliderHandle,
    pub(super) object: RigidBodyHandle,
    /// The object's ball.
    pub(super) ball: ColliderHandle,
}

impl Objects {
    /// Puts table and object into a world.
    pub(super) fn insert(friction: f64, bodies: &mut RigidBodySet, colliders: &mut ColliderSet) -> Self {
        let table = ColliderBuilder::halfspace(Unit::new_unchecked(Vector::Z))
            .position(Pose::from_translation(Vector::Z * scene::TABLE))
            .collision_groups(Role::Table.groups());
        let table = colliders.insert(table.friction(friction));

        let mass =
            MassProperties::new(Vector::ZERO, scene::OBJECT_MASS, Vector::splat(scene::OBJECT_INERTIA));
        let object =
            bodies.insert(RigidBodyBuilder::dynamic().additional_mass_properties(mass).can_sleep(false));
        let ball = ColliderBuilder::ball(scene::OBJECT_RADIUS)
            .collision_groups(Role::Ball.groups())
            .active_hooks(ActiveHooks::FILTER_CONTACT_PAIRS);
        let [ball, _] = [ball, disc().collision_groups(Role::Base.groups())]
            .map(|shape| colliders.insert_with_parent(shape.density(0.0).friction(friction), object, bodies));
        Self { table, object, ball }
    }

    /// Places the object at rest, by its centre and orientation (w, x, y, z).
    pub(super) fn place(self, bodies: &mut RigidBodySet, centre: [f64; 3], [w, x, y, z]: [f64; 4]) {
        let rotation = Rotation::from_xyzw(x, y, z, w);
        if let Some(object) = bodies.get_mut(self.object) {
            object.set_position(Pose { rotation, translation: Vector::from_array(centre) }, true);
        }
    }
}

/// The base: a cylinder from the cut up to the ball's centre.
fn disc() -> ColliderBuilder {
    let (ball, cut) = (scene::OBJECT_RADIUS, scene::OBJECT_BASE);
    // A cylinder's axis is y.
    let rotation = Rotation::from_rotation_arc(Vector::Y, Vector::Z);
    ColliderBuilder::cylinder(0.5 * cut, (ball * ball - cut * cut).sqrt())
        .position(Pose { rotation, translation: Vector::Z * (-0.5 * cut) })
}

/// Keeps the part of the ball that was cut off from touching the table.
impl PhysicsHooks for Objects {
    fn filter_contact_pair(&self, pair: &PairFilterContext<'_>) -> Option<SolverFlags> {
        if self.table != pair.collider1 && self.table != pair.collider2 {
            return Some(SolverFlags::default());
        }
        let upright = (pair.bodies.get(self.object)?.rotation() * Vector::Z).z;
        (upright < scene::OBJECT_BASE / scene::OBJECT_RADIUS).then(SolverFlags::default)
    }
}
