//! Where shapes touch: a fixed list of candidate contacts, tested in every step.

use fearless_simd::{Select, Simd, SimdBase, SimdMask};
use nalgebra::Vector3;

use super::kinematics::Pose;
use super::lanes::{Mask, Real, clamp, max, min, reciprocal, splat};
use super::object::Object;
use super::spatial::{Motion, Rotation, Vec3, vec3};
use super::tree::{CAPSULES, Capsule, KNOBS, Shapes};
use crate::robot::{JOINTS, joint};
use crate::scene;

/// Contacts are prepared where less than this gap, in metres, is left after a step without contact impulses: room for
/// what the impulses themselves push together.
const MARGIN: f64 = 0.001;

/// Points of the object that can touch the table: three fixed ones on the rim of its base, and its lowest point.
const OBJECT_TABLE: usize = 4;
/// Sine of the object's tilt below which the base's fixed points support it alone.
const LEVEL: f64 = 0.002;

/// Number of the first candidate between robot and object: the palm, followed by the fingertips.
pub(super) const FIRST_TOUCH: usize = OBJECT_TABLE + KNOBS;
/// Number of candidates.
pub(super) const CANDIDATES: usize = FIRST_TOUCH + 1 + CAPSULES;

/// A candidate that is close in at least one lane.
#[derive(Clone, Copy)]
pub(super) struct Contact<S: Simd> {
    /// Number of the candidate.
    pub(super) candidate: usize,
    /// The lanes in which it is close.
    pub(super) close: Mask<S>,
    /// Distance of the surfaces; negative where they overlap.
    pub(super) gap: Real<S>,
    /// Unit vector from the object, or from the table, to the other body.
    pub(super) normal: Vec3<S>,
    /// Where it acts.
    pub(super) point: Vec3<S>,
    /// The robot's link in it, if it is the robot's.
    pub(super) link: Option<usize>,
    /// Whether the object is in it.
    pub(super) on_object: bool,
}

/// What moves, and for how long until contacts are looked for again.
pub(super) struct Movement<'a, S: Simd> {
    /// Poses of the robot's links.
    pub(super) poses: &'a [Pose<S>; JOINTS],
    /// Their velocities at the end of the step, contacts aside.
    pub(super) velocities: &'a [Motion<S>; JOINTS],
    pub(super) object: &'a Object<S>,
    /// Length of a step, s.
    pub(super) step: f64,
}

impl<S: Simd> Movement<'_, S> {
    /// Velocity of a point of a link.
    #[inline(always)]
    fn velocity(&self, link: usize, point: Vec3<S>) -> Vec3<S> {
        let velocity = &self.velocities[link];
        velocity.linear + velocity.angular.cross(point)
    }

    /// Whether a gap that opens at some speed may be closed by the end of the step.
    #[inline(always)]
    fn closes(&self, simd: S, gap: Real<S>, speed: Real<S>) -> Mask<S> {
        (gap + min(simd, speed, splat(simd, 0.0)) * self.step).simd_lt(MARGIN)
    }
}

/// Finds every candidate that is close in any lane, in a fixed order.
pub(super) fn find<S: Simd>(
    simd: S,
    shapes: &Shapes,
    movement: &Movement<'_, S>,
    found: &mut Vec<Contact<S>>,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            found.clear();
            object_on_table(simd, movement, found);
            robot_on_table(simd, shapes, movement, found);
            robot_on_object(simd, shapes, movement, found);
        },
    );
}

#[inline(always)]
fn up<S: Simd>(simd: S) -> Vec3<S> {
    Vec3::splat(simd, &Vector3::z())
}

#[inline(always)]
fn object_on_table<S: Simd>(simd: S, movement: &Movement<'_, S>, found: &mut Vec<Contact<S>>) {
    let object = movement.object;
    let bottom = object.centre - up(simd).scale(scene::OBJECT_RADIUS);
    let low = movement.closes(simd, bottom.z - scene::TABLE, object.twist.linear.z);
    if !low.any_true() {
        return;
    }
    let base = scene::OBJECT_BASE;
    let rim = (scene::OBJECT_RADIUS * scene::OBJECT_RADIUS - base * base).sqrt();
    let rotation = object.rotation();
    let [x, y] = [rotation.x.scale(rim), rotation.y.scale(rim)];
    let middle = object.centre - rotation.z.scale(base);
    let (half, height) = (0.5, 0.75_f64.sqrt());
    // The ball's lowest point belongs to the object unless the base was cut there; then it is the lowest on the rim.
    let round = rotation.z.z.simd_lt(base / scene::OBJECT_RADIUS);
    let uphill = up(simd) - rotation.z * rotation.z.z;
    let tilt = uphill.norm();
    let lowest = middle - uphill * (splat(simd, rim) / max(simd, tilt, splat(simd, LEVEL)));
    let lowest = select(round, bottom, lowest);
    let points = [
        (middle + x, low),
        (middle - x.scale(half) + y.scale(height), low),
        (middle - x.scale(half) - y.scale(height), low),
        (lowest, round | tilt.simd_gt(LEVEL)),
    ];
    for (candidate, (point, allowed)) in points.into_iter().enumerate() {
        let gap = point.z - scene::TABLE;
        let speed = object.twist.at(point - object.centre).z;
        let close = movement.closes(simd, gap, speed) & allowed;
        if close.any_true() {
            let normal = up(simd);
            found.push(Contact { candidate, close, gap, normal, point, link: None, on_object: true });
        }
    }
}

#[inline(always)]
fn robot_on_table<S: Simd>(
    simd: S,
    shapes: &Shapes,
    movement: &Movement<'_, S>,
    found: &mut Vec<Contact<S>>,
) {
    for (candidate, knob) in (OBJECT_TABLE..).zip(&shapes.knobs) {
        let point = movement.poses[knob.link].point(&knob.point) - up(simd).scale(knob.radius);
        let gap = point.z - scene::TABLE;
        let close = movement.closes(simd, gap, movement.velocity(knob.link, point).z);
        if close.any_true() {
            let link = Some(knob.link);
            found.push(Contact { candidate, close, gap, normal: up(simd), point, link, on_object: false });
        }
    }
}

#[inline(always)]
fn robot_on_object<S: Simd>(
    simd: S,
    shapes: &Shapes,
    movement: &Movement<'_, S>,
    found: &mut Vec<Contact<S>>,
) {
    let centre = movement.object.centre;
    let palm = ball_and_palm(simd, shapes, &movement.poses[joint::HAND], centre);
    press(simd, FIRST_TOUCH, joint::HAND, palm, movement, found);
    for (candidate, capsule) in (FIRST_TOUCH + 1..).zip(&shapes.capsules) {
        let distance = ball_and_capsule(simd, capsule, &movement.poses[capsule.link], centre);
        press(simd, candidate, capsule.link, distance, movement, found);
    }
}

/// Adds a contact between robot and object if it is close.
#[inline(always)]
fn press<S: Simd>(
    simd: S,
    candidate: usize,
    link: usize,
    (gap, normal): (Real<S>, Vec3<S>),
    movement: &Movement<'_, S>,
    found: &mut Vec<Contact<S>>,
) {
    let object = movement.object;
    let arm = normal.scale(scene::OBJECT_RADIUS);
    let point = object.centre + arm;
    let speed = normal.dot(movement.velocity(link, point) - object.twist.at(arm));
    let close = movement.closes(simd, gap, speed);
    if close.any_true() {
        found.push(Contact { candidate, close, gap, normal, point, link: Some(link), on_object: true });
    }
}

/// Gap, and normal from the ball, between the object's ball and a capsule.
#[inline(always)]
fn ball_and_capsule<S: Simd>(
    simd: S,
    capsule: &Capsule,
    pose: &Pose<S>,
    centre: Vec3<S>,
) -> (Real<S>, Vec3<S>) {
    let start = pose.point(&capsule.start);
    let axis = pose.rotation.turn(&capsule.axis);
    let along = (centre - start).dot(axis);
    let nearest = start + axis * clamp(simd, along, splat(simd, 0.0), splat(simd, capsule.length));
    let (distance, normal) = direction(simd, nearest - centre, up(simd));
    (distance - (capsule.radius + scene::OBJECT_RADIUS), normal)
}

/// Gap, and normal from the ball, between the object's ball and the palm's box.
#[inline(always)]
fn ball_and_palm<S: Simd>(simd: S, shapes: &Shapes, hand: &Pose<S>, centre: Vec3<S>) -> (Real<S>, Vec3<S>) {
    let palm = Rotation {
        x: hand.rotation.turn(&shapes.palm_rotation.column(0).into_owned()),
        y: hand.rotation.turn(&shapes.palm_rotation.column(1).into_owned()),
        z: hand.rotation.turn(&shapes.palm_rotation.column(2).into_owned()),
    };
    let middle = hand.point(&shapes.palm_centre);
    let local = palm.turn_back(centre - middle);
    let half = Vec3::splat(simd, &shapes.palm_half);
    let nearest = vec3(
        clamp(simd, local.x, -half.x, half.x),
        clamp(simd, local.y, -half.y, half.y),
        clamp(simd, local.z, -half.z, half.z),
    );
    let offset = nearest - local;
    let (distance, normal) =
        direction(simd, palm.x * offset.x + palm.y * offset.y + palm.z * offset.z, palm.y);
    (distance - scene::OBJECT_RADIUS, normal)
}

/// `a` in the lanes where the mask holds, `b` elsewhere.
#[inline(always)]
fn select<S: Simd>(mask: Mask<S>, a: Vec3<S>, b: Vec3<S>) -> Vec3<S> {
    vec3(mask.select(a.x, b.x), mask.select(a.y, b.y), mask.select(a.z, b.z))
}

/// Length and direction of a vector; `otherwise` where it has none.
#[inline(always)]
fn direction<S: Simd>(simd: S, v: Vec3<S>, otherwise: Vec3<S>) -> (Real<S>, Vec3<S>) {
    let length = v.norm();
    let scale = reciprocal(simd, max(simd, length, splat(simd, 1e-9)));
    (length, select(length.simd_lt(1e-9), otherwise, v * scale))
}
