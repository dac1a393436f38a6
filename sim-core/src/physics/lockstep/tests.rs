//! The lanes against plain scalars, and the robot's motion against the laws of mechanics.

mod contacts;
mod referee;

use fearless_simd::{Level, Simd, dispatch};
use nalgebra::{Matrix3, Point3, SMatrix, SVector, Vector3};
use proptest::prelude::*;

use super::*;
use crate::robot::Kinematics;

/// A lane that every instruction set has.
const LANE: usize = 1;

type Square = SMatrix<f64, JOINTS, JOINTS>;
type Column = SVector<f64, JOINTS>;

/// The robot with its servos off: no springs, no damping, no stops.
fn limp(robot: &RobotModel) -> Tree {
    let mut tree = Tree::new(robot).unwrap();
    for link in &mut tree.links {
        link.servo = tree::Servo { lower: -1e9, upper: 1e9, stiffness: 0.0, damping: 0.0, ..link.servo };
    }
    tree
}

/// Joint-space inertia with armature, from Jacobians: the sum of m Jᵀ J + Rᵀ I R over the links.
fn inertia(robot: &RobotModel, angles: &[f64; JOINTS]) -> Square {
    let kinematics = Kinematics::new(robot, angles);
    let mut sum = Square::zeros();
    for (i, joint) in robot.joints.iter().enumerate() {
        let pose = kinematics.links[i];
        let columns = kinematics.jacobian(robot, i, &(pose * joint.body.centre));
        let linear = SMatrix::<f64, 3, JOINTS>::from_columns(&columns);
        let mut angular = SMatrix::<f64, 3, JOINTS>::zeros();
        let mut next = Some(i);
        while let Some(link) = next {
            angular.set_column(link, &kinematics.axes[link]);
            next = robot.joints[link].parent;
        }
        let rotation: Matrix3<f64> = pose.rotation.to_rotation_matrix().into_inner();
        let world = rotation * joint.body.inertia * rotation.transpose();
        sum += linear.transpose() * linear * joint.body.mass + angular.transpose() * world * angular;
        sum[(i, i)] += joint.armature;
    }
    sum
}

fn posture() -> impl Strategy<Value = [f64; JOINTS]> {
    let robot = RobotModel::icub().unwrap();
    prop::array::uniform20(0.0..1.0_f64)
        .prop_map(move |shares| std::array::from_fn(|i| robot.joints[i].angle(shares[i])))
}

/// [`LANE`] holds the posture; the others hold another one.
fn spread<S: Simd>(simd: S, values: &[f64; JOINTS]) -> [Real<S>; JOINTS] {
    values.map(|value| {
        let mut lanes = splat(simd, 0.1);
        lanes[LANE] = value;
        lanes
    })
}

fn poses<S: Simd>(simd: S, tree: &Tree, angles: &[Real<S>; JOINTS]) -> [Pose<S>; JOINTS] {
    let origin = Pose { rotation: Rotation::splat(simd, &Matrix3::identity()), position: Vec3::zero(simd) };
    let mut poses = [origin; JOINTS];
    kinematics::forward(simd, tree, angles, &mut poses);
    poses
}

fn capsule_ends<S: Simd>(simd: S, angles: &[f64; JOINTS]) -> Vec<(Point3<f64>, Point3<f64>)> {
    let robot = RobotModel::icub().unwrap();
    let tree = Tree::new(&robot).unwrap();
    let poses = poses(simd, &tree, &spread(simd, angles));
    let kinematics = Kinematics::new(&robot, angles);
    let fingers = (0..5).flat_map(|finger| [finger + 5, finger]);
    let lanes = [10].into_iter().chain(fingers).map(|i| &tree.shapes.capsules[i]);
    lanes
        .zip(&robot.capsules)
        .flat_map(|(lane, scalar)| {
            [(lane.start, scalar.start), (lane.end(), scalar.end)].map(|(local, reference)| {
                let found = get(&poses[lane.link].point(&local), LANE);
                (Point3::from(found), kinematics.links[scalar.link] * reference)
            })
        })
        .collect()
}

/// The inverse of A over a step, column by column, from the factor.
fn inverse_of_factored<S: Simd>(simd: S, tree: &Tree, angles: &[f64; JOINTS], step: f64) -> Square {
    let angles = spread(simd, angles);
    let zeros = [splat(simd, 0.0); JOINTS];
    let joints = Joints { angles, velocities: zeros, targets: angles };
    let mut factor = Factor::new(simd);
    let mut whitened = zeros;
    dynamics::smooth(simd, tree, &poses(simd, tree, &angles), &joints, step, &mut factor, &mut whitened);
    let mut inverse = Square::zeros();
    for column in 0..JOINTS {
        let mut whitened = zeros;
        let mut force = spatial::Force::zero(simd);
        let mut joint = splat(simd, 1.0);
        let mut next = Some(column);
        while let Some(i) = next {
            whitened[i] = factor.transmit(i, &mut force, joint);
            joint = splat(simd, 0.0);
            next = tree.links[i].parent;
        }
        let mut velocities = zeros;
        dynamics::recover(simd, tree, &mut factor, &whitened, &mut velocities);
        inverse.set_column(column, &Column::from_fn(|i, _| velocities[i][LANE]));
    }
    inverse
}

/// Kinetic energy at the start, and its largest relative change, while the limp arm swings for 0.2 s.
fn energy_drift<S: Simd>(simd: S, angles: &[f64; JOINTS], velocities: &[f64; JOINTS], steps: u32) -> f64 {
    let robot = RobotModel::icub().unwrap();
    let tree = limp(&robot);
    let step = 0.2 / f64::from(steps);
    let mut joints = Joints {
        angles: spread(simd, angles),
        velocities: spread(simd, velocities),
        targets: spread(simd, angles),
    };
    let mut factor = Factor::new(simd);
    let energy = |joints: &Joints<S>| {
        let velocity = Column::from_fn(|i, _| joints.velocities[i][LANE]);
        let inertia = inertia(&robot, &std::array::from_fn(|i| joints.angles[i][LANE]));
        0.5 * velocity.dot(&(inertia * velocity))
    };
    let first = energy(&joints);
    let mut worst: f64 = 0.0;
    for _ in 0..steps {
        let mut whitened = [splat(simd, 0.0); JOINTS];
        let poses = poses(simd, &tree, &joints.angles);
        dynamics::smooth(simd, &tree, &poses, &joints, step, &mut factor, &mut whitened);
        dynamics::recover(simd, &tree, &mut factor, &whitened, &mut joints.velocities);
        for (angle, velocity) in joints.angles.iter_mut().zip(&joints.velocities) {
            *angle += *velocity * step;
        }
        worst = worst.max((energy(&joints) / first - 1.0).abs());
    }
    worst
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn links_are_where_scalar_kinematics_puts_them(angles in posture()) {
        for (found, expected) in dispatch!(Level::new(), simd => capsule_ends(simd, &angles)) {
            prop_assert!((found - expected).norm() < 1e-12, "{} {}", found, expected);
        }
    }

    #[test]
    fn the_factor_inverts_the_joint_space_inertia(angles in posture()) {
        let robot = RobotModel::icub().unwrap();
        let tree = limp(&robot);
        let inverse = dispatch!(Level::new(), simd => inverse_of_factored(simd, &tree, &angles, 0.01));
        let error = (inertia(&robot, &angles) * inverse - Square::identity()).norm();
        prop_assert!(error < 1e-9, "{error}");
    }

    #[test]
    fn servos_add_their_damping_and_stiffness_to_the_inertia(angles in posture()) {
        let robot = RobotModel::icub().unwrap();
        let tree = Tree::new(&robot).unwrap();
        let step = 0.005;
        let inverse = dispatch!(Level::new(), simd => inverse_of_factored(simd, &tree, &angles, step));
        let mut stiffened = inertia(&robot, &angles);
        for (i, joint) in robot.joints.iter().enumerate() {
            stiffened[(i, i)] += step * joint.damping + step * step * joint.stiffness;
        }
        let error = (stiffened * inverse - Square::identity()).norm();
        prop_assert!(error < 1e-9, "{error}");
    }

    #[test]
    fn the_swinging_arm_keeps_its_energy_the_better_the_smaller_the_step(
        angles in posture(),
        shares in prop::array::uniform20(-1.0..1.0_f64),
    ) {
        // Fingers swing slowly: their links are light, and no spring holds them.
        let velocities = std::array::from_fn(|i| shares[i] * if i < joint::CARRIER.end { 2.0 } else { 0.5 });
        let drift = |steps| dispatch!(Level::new(), simd => energy_drift(simd, &angles, &velocities, steps));
        let (coarse, fine) = (drift(100), drift(400));
        prop_assert!(fine < 0.01, "{fine}");
        prop_assert!(fine < 0.5 * coarse + 1e-6, "{coarse} {fine}");
    }
}

#[test]
fn the_palm_faces_along_the_hands_negative_y_axis() {
    let robot = RobotModel::icub().unwrap();
    let angles = robot.joints.each_ref().map(|joint| joint.angle(0.4));
    let mut engine = engine(&robot, &Physics::default(), Instructions::Best).unwrap();
    let placement =
        Placement { angles, targets: angles, object: [0.0, 0.0, 1.0], orientation: [1.0, 0.0, 0.0, 0.0] };
    engine.place(1, &placement);
    let seen = engine.observe(1);
    let hand = Kinematics::new(&robot, &angles).links[joint::HAND];
    assert!((Point3::from(seen.palm) - hand * robot.palm.point()).norm() < 1e-12);
    assert!((Vector3::from(seen.palm_normal) - hand * Vector3::new(0.0, -1.0, 0.0)).norm() < 1e-12);
}
