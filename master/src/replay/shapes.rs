//! The shapes of a moment, as the page draws them, and the camera it starts with.

use super::{Moment, Recording};

/// A shape, in metres in the robot's root frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Shape {
    /// A ball.
    Ball {
        /// Its centre.
        centre: [f64; 3],
        /// Its radius.
        radius: f64,
    },
    /// A cylinder with round ends.
    Capsule {
        /// The ends of its axis.
        ends: [[f64; 3]; 2],
        /// Its radius.
        radius: f64,
    },
    /// A box. Bit 0 of a corner's number is its side along the first edge, and so on.
    Box {
        /// Its corners.
        corners: [[f64; 3]; 8],
    },
}

/// What colour a shape has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Tint {
    /// The table's.
    Table,
    /// The robot's.
    Skin,
    /// That of a part that feels the object.
    Touch,
    /// The object's.
    Object,
    /// The target's.
    Target,
    /// That of the area around the target.
    Around,
    /// That of what the robot attends to.
    Attention,
}

impl Tint {
    /// Red, green and blue.
    #[must_use]
    pub(super) const fn rgb(self) -> [u8; 3] {
        match self {
            Self::Table => [0xe9, 0xe4, 0xdb],
            Self::Skin => [0xc6, 0xcc, 0xd6],
            Self::Touch => [0xf5, 0x9e, 0x0b],
            Self::Object => [0xd0, 0x3a, 0x3a],
            Self::Target | Self::Around => [0x1f, 0x9d, 0x57],
            Self::Attention => [0x25, 0x63, 0xeb],
        }
    }

    /// From 0, which lets all through, to 1.
    #[must_use]
    pub(super) const fn opacity(self) -> f64 {
        match self {
            Self::Around | Self::Attention => 0.2,
            _ => 1.0,
        }
    }
}

/// The part of the table that is drawn: from and to along x, and along y.
pub(super) const TABLE: [[f64; 2]; 2] = [[-0.62, -0.1], [-0.42, 0.32]];
/// Radius of what marks the target.
pub(super) const TARGET: f64 = 0.012;
/// Radius of the area around the target.
pub(super) const AROUND: f64 = 0.06;
/// Radius of what marks that which the robot attends to.
pub(super) const ATTENTION: f64 = 0.05;
/// How thick the table is drawn.
const THICKNESS: f64 = 0.01;
/// Segments of the arm without shapes of their own in the simulator, from the waist, and those of them that are the
/// torso's.
const BARE: (usize, usize) = (6, 2);

/// The shapes of a moment by what they belong to: `table`, `robot`, `object`, `target`, `attention`.
#[must_use]
pub(super) fn at(recording: &Recording, moment: &Moment) -> Vec<(&'static str, Vec<(Shape, Tint)>)> {
    let table = std::array::from_fn(|corner| {
        let side = |axis: usize| TABLE[axis][corner >> axis & 1];
        let depth = if corner >> 2 & 1 == 0 { THICKNESS } else { 0.0 };
        [side(0), side(1), recording.table - depth]
    });
    let mut parts = vec![
        ("table", vec![(Shape::Box { corners: table }, Tint::Table)]),
        ("robot", robot(recording, moment)),
        (
            "object",
            vec![(Shape::Ball { centre: moment.object, radius: recording.object_radius }, Tint::Object)],
        ),
        (
            "target",
            vec![
                (Shape::Ball { centre: recording.target, radius: TARGET }, Tint::Target),
                (Shape::Ball { centre: recording.target, radius: AROUND }, Tint::Around),
            ],
        ),
    ];
    if let Some(centre) = attended(recording, moment) {
        parts.push(("attention", vec![(Shape::Ball { centre, radius: ATTENTION }, Tint::Attention)]));
    }
    parts
}

/// Where the thing is that the robot attends to; nothing at the start.
#[must_use]
pub(super) fn attended(recording: &Recording, moment: &Moment) -> Option<[f64; 3]> {
    let focus = moment.step.as_ref()?.motors.first()?;
    Some(if *focus > 0.5 { recording.target } else { moment.object })
}

/// Torso, arm, hand and fingers.
fn robot(recording: &Recording, moment: &Moment) -> Vec<(Shape, Tint)> {
    let tint = |felt: bool| if felt { Tint::Touch } else { Tint::Skin };
    let mut shapes: Vec<(Shape, Tint)> = Vec::new();
    for (number, ends) in moment.arm.windows(2).take(BARE.0).enumerate() {
        let radius = if number < BARE.1 { 0.04 } else { 0.03 };
        shapes.push((Shape::Capsule { ends: [ends[0], ends[1]], radius }, Tint::Skin));
    }
    for (part, ends) in recording.capsules.iter().zip(&moment.capsules) {
        let felt = part.sensor.is_some_and(|sensor| moment.touch[sensor]);
        shapes.push((Shape::Capsule { ends: *ends, radius: part.radius }, tint(felt)));
    }
    shapes.push((Shape::Box { corners: moment.palm }, tint(moment.touch[0])));
    shapes
}
