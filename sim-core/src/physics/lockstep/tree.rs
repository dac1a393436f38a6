//! The robot's constants in the form the lanes use: every link's frame is turned so that its joint's axis is z.

use nalgebra::{Matrix3, Rotation3, SymmetricEigen, Vector3};

use crate::robot::{Body, JOINTS, Part, RobotError, RobotModel, joint};

/// Fingers, the thumb among them.
const FINGERS: usize = 5;
/// Capsules: two a finger, and the forearm.
pub(super) const CAPSULES: usize = 2 * FINGERS + 1;
/// Points that can touch the table.
pub(super) const KNOBS: usize = 2 * FINGERS + 2 + 8;

/// Most joints between the root and a link.
pub(super) const MAX_CHAIN: usize = 12;

/// The robot.
pub(super) struct Tree {
    pub(super) links: [Link; JOINTS],
    /// The joints that carry each link.
    pub(super) chains: [Chain; JOINTS],
    pub(super) shapes: Shapes,
}

/// The joints that carry a link: some of a finger, after the first ones of torso and arm.
#[derive(Clone, Copy)]
pub(super) struct Chain {
    finger: (usize, usize),
    carrier: usize,
}

impl Chain {
    fn to(link: usize, links: &[Link; JOINTS]) -> Self {
        let mut first = link + 1;
        let mut next = Some(link);
        while let Some(i) = next.filter(|i| *i > joint::HAND) {
            first = i;
            next = links[i].parent;
        }
        if link <= joint::HAND {
            return Self { finger: (0, 0), carrier: link + 1 };
        }
        Self { finger: (first, link + 1), carrier: joint::CARRIER.end }
    }

    /// From the link towards the root.
    #[inline(always)]
    pub(super) fn joints(self) -> impl Iterator<Item = usize> {
        (self.finger.0..self.finger.1).rev().chain((0..self.carrier).rev())
    }
}

/// A joint with its servo, and the link it moves.
pub(super) struct Link {
    pub(super) parent: Option<usize>,
    /// Orientation in the parent's frame at angle 0; none where it is the parent's.
    pub(super) rotation: Option<Matrix3<f64>>,
    /// Origin in the parent's frame.
    pub(super) offset: Vector3<f64>,
    pub(super) mass: Mass,
    pub(super) servo: Servo,
}

/// Mass distribution of a link. The rotational inertia about the centre is `round` in all directions plus an excess
/// about each of up to two principal axes, which is quick to turn.
pub(super) struct Mass {
    pub(super) mass: f64,
    pub(super) centre: Vector3<f64>,
    pub(super) round: f64,
    pub(super) excess: Vec<(f64, Vector3<f64>)>,
}

/// Servo of a joint; see [`crate::robot::Joint`] for the units.
#[derive(Clone, Copy)]
pub(super) struct Servo {
    pub(super) lower: f64,
    pub(super) upper: f64,
    pub(super) stiffness: f64,
    pub(super) damping: f64,
    pub(super) torque_limit: f64,
    pub(super) armature: f64,
}

/// A capsule fixed to a link: from `start` along `axis` (a unit vector) for `length`.
pub(super) struct Capsule {
    pub(super) link: usize,
    pub(super) start: Vector3<f64>,
    pub(super) axis: Vector3<f64>,
    pub(super) length: f64,
    pub(super) radius: f64,
}

impl Capsule {
    pub(super) fn end(&self) -> Vector3<f64> {
        self.start + self.axis * self.length
    }
}

/// A point of the robot that can touch the table: the centre of a sphere fixed to a link.
pub(super) struct Knob {
    pub(super) link: usize,
    pub(super) point: Vector3<f64>,
    pub(super) radius: f64,
}

/// What can touch something.
pub(super) struct Shapes {
    /// The last two phalanges by finger, the first phalanges by finger, the forearm.
    pub(super) capsules: [Capsule; CAPSULES],
    /// What of the robot can touch the table: both ends of the fingertips' capsules and the forearm's, corners of
    /// the palm.
    pub(super) knobs: [Knob; KNOBS],
    /// The palm's box: pose in the hand's frame and half sides.
    pub(super) palm_rotation: Matrix3<f64>,
    pub(super) palm_centre: Vector3<f64>,
    pub(super) palm_half: Vector3<f64>,
}

impl Tree {
    pub(super) fn new(robot: &RobotModel) -> Result<Self, RobotError> {
        let turns: [Rotation3<f64>; JOINTS] = std::array::from_fn(|i| turn_to(&robot.joints[i].axis));
        let links = std::array::from_fn(|i| link(robot, i, &turns));
        let chains = std::array::from_fn(|i| Chain::to(i, &links));
        Ok(Self { links, chains, shapes: shapes(robot, &turns)? })
    }
}

/// The rotation whose z axis is `axis`.
fn turn_to(axis: &Vector3<f64>) -> Rotation3<f64> {
    if (axis - Vector3::z()).norm() < 1e-9 {
        return Rotation3::identity();
    }
    let side = if axis.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
    let x = (side - axis * axis.dot(&side)).normalize();
    let y = axis.cross(&x);
    Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, y, *axis]))
}

fn link(robot: &RobotModel, i: usize, turns: &[Rotation3<f64>; JOINTS]) -> Link {
    let joint = &robot.joints[i];
    let parent_turn = joint.parent.map_or_else(Rotation3::identity, |parent| turns[parent]);
    let rotation = parent_turn.inverse() * joint.origin.rotation.to_rotation_matrix() * turns[i];
    let straight = (rotation.matrix() - Matrix3::identity()).norm() < 1e-12;
    Link {
        parent: joint.parent,
        rotation: (!straight).then(|| rotation.into_inner()),
        offset: parent_turn.inverse() * joint.origin.translation.vector,
        mass: mass(&joint.body, &turns[i]),
        servo: Servo {
            lower: joint.lower,
            upper: joint.upper,
            stiffness: joint.stiffness,
            damping: joint.damping,
            torque_limit: joint.torque_limit,
            armature: joint.armature,
        },
    }
}

fn mass(body: &Body, turn: &Rotation3<f64>) -> Mass {
    let inertia = turn.matrix().transpose() * body.inertia * turn.matrix();
    let principal = SymmetricEigen::new(inertia);
    // The moment that lies nearest to another one is the round part; equal moments then need no axis.
    let moments = principal.eigenvalues;
    let spread = |i: usize| {
        (0..3).filter(|j| *j != i).map(|j| (moments[i] - moments[j]).abs()).fold(f64::MAX, f64::min)
    };
    let round = (0..3).fold(0, |best, i| if spread(i) < spread(best) { i } else { best });
    let excess = (0..3)
        .filter(|i| (moments[*i] - moments[round]).abs() > 1e-12 * moments[round])
        .map(|i| (moments[i] - moments[round], principal.eigenvectors.column(i).into_owned()))
        .collect();
    Mass { mass: body.mass, centre: turn.inverse() * body.centre.coords, round: moments[round], excess }
}

fn shapes(robot: &RobotModel, turns: &[Rotation3<f64>; JOINTS]) -> Result<Shapes, RobotError> {
    let capsule = |part: Part| {
        let capsule = robot.capsule(part)?;
        let back = turns[capsule.link].inverse();
        let axis = capsule.end - capsule.start;
        Ok(Capsule {
            link: capsule.link,
            start: back * capsule.start.coords,
            axis: back * axis.normalize(),
            length: axis.norm(),
            radius: capsule.radius,
        })
    };
    let parts: [Part; CAPSULES] = std::array::from_fn(|i| match i {
        0..FINGERS => Part::Fingertip(i),
        _ if i < 2 * FINGERS => Part::Proximal(i - FINGERS),
        _ => Part::Forearm,
    });
    let capsules: Vec<Capsule> = parts.into_iter().map(capsule).collect::<Result<_, RobotError>>()?;
    let back = turns[joint::HAND].inverse();
    let palm_rotation = (back * robot.palm.pose.rotation.to_rotation_matrix()).into_inner();
    let palm_centre = back * robot.palm.pose.translation.vector;
    let palm_half = robot.palm.half;

    let ends = |capsule: &Capsule| {
        [capsule.start, capsule.end()].map(|point| Knob { link: capsule.link, point, radius: capsule.radius })
    };
    let corners = (0..8_u8).map(|corner| {
        let side = |bit: u8| if corner >> bit & 1 == 0 { -1.0 } else { 1.0 };
        let local = palm_half.component_mul(&Vector3::new(side(0), side(1), side(2)));
        Knob { link: joint::HAND, point: palm_centre + palm_rotation * local, radius: 0.0 }
    });
    let tips = capsules[..FINGERS].iter().chain(capsules.last()).flat_map(ends);
    let knobs: Vec<Knob> = tips.chain(corners).collect();
    let complete = || RobotError::incomplete("collision shapes");
    Ok(Shapes {
        capsules: capsules.try_into().map_err(|_| complete())?,
        knobs: knobs.try_into().map_err(|_| complete())?,
        palm_rotation,
        palm_centre,
        palm_half,
    })
}
