//! Where the links are, how heavy they are to move, and what their motion does to each other.

use nalgebra::Rotation3;
use serde::Deserialize;

use super::python::Python;
use super::*;

/// MuJoCo's account of a posture.
#[derive(Deserialize)]
struct Seen {
    positions: Vec<[f64; 3]>,
    /// Row by row.
    rotations: Vec<[f64; 9]>,
    palm: [f64; 3],
    tips: Vec<[f64; 3]>,
}

/// Points of each link's URDF frame: its origin, and what shows how it is turned.
const POINTS: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]];

/// The lanes' account of a posture: the points of each link, the palm and the fingers' tips.
struct Lanes {
    links: Vec<[Vector3<f64>; POINTS.len()]>,
    palm: Vector3<f64>,
    tips: Vec<Vector3<f64>>,
}

fn lanes<S: Simd>(
    simd: S,
    tree: &Tree,
    landmarks: &Landmarks,
    turns: &Turns,
    angles: &[f64; JOINTS],
) -> Lanes {
    let poses = poses(simd, tree, &spread(simd, angles));
    let at = |link: usize, point: &Vector3<f64>| Vector3::from(get(&poses[link].point(point), LANE));
    let frame = |link: usize| POINTS.map(|point| at(link, &(turns[link].inverse() * Vector3::from(point))));
    let tips = &tree.shapes.capsules[..5];
    Lanes {
        links: (0..JOINTS).map(frame).collect(),
        palm: at(joint::HAND, &landmarks.palm),
        tips: tips.iter().map(|tip| at(tip.link, &tip.end())).collect(),
    }
}

/// How the tree's frames are turned against the URDF's.
type Turns = [Rotation3<f64>; JOINTS];

fn turns(robot: &RobotModel, tree: &Tree) -> Turns {
    let scalar = Kinematics::new(robot, &[0.0; JOINTS]);
    dispatch!(Level::baseline(), simd => {
        let poses = poses(simd, tree, &[splat(simd, 0.0); JOINTS]);
        std::array::from_fn(|i| {
            let Rotation { x, y, z } = &poses[i].rotation;
            let columns = [x, y, z].map(|column| Vector3::from(get(column, LANE)));
            let lane = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&columns));
            scalar.links[i].rotation.to_rotation_matrix().inverse() * lane
        })
    })
}

#[test]
#[ignore = "asks MuJoCo: run `just referee`"]
fn palm_fingertips_and_links_are_where_mujoco_puts_them() {
    let mut random = Random::new(1);
    let tree = Tree::new(&random.robot).unwrap();
    let landmarks = Landmarks::new(&random.robot, &tree);
    let turns = turns(&random.robot, &tree);
    let mut python = Python::start();
    let mut links = Bound::new("links in 10 000 postures, m", 1e-9);
    let mut points = Bound::new("palm and fingertips in 10 000 postures, m", 1e-9);
    for _ in 0..10 {
        let postures: Vec<[f64; JOINTS]> = (0..1000).map(|_| random.posture()).collect();
        let answer: Vec<Seen> = python.ask("poses", &postures);
        assert_eq!(answer.len(), postures.len());
        for (angles, seen) in postures.iter().zip(&answer) {
            let ours = dispatch!(Level::new(), simd => lanes(simd, &tree, &landmarks, &turns, angles));
            assert_eq!([seen.positions.len(), seen.rotations.len(), seen.tips.len()], [JOINTS, JOINTS, 5]);
            for ((frame, position), rotation) in ours.links.iter().zip(&seen.positions).zip(&seen.rotations) {
                let rotation = Matrix3::from_row_slice(rotation);
                for (point, local) in frame.iter().zip(POINTS) {
                    links.take((Vector3::from(*position) + rotation * Vector3::from(local) - point).norm());
                }
            }
            points.take((Vector3::from(seen.palm) - ours.palm).norm());
            for (tip, expected) in ours.tips.iter().zip(&seen.tips) {
                points.take((tip - Vector3::from(*expected)).norm());
            }
        }
    }
    links.hold();
    points.hold();
}

/// MuJoCo's account of a motion.
#[derive(Deserialize)]
struct Dynamics {
    inertia: Vec<f64>,
    bias: Vec<f64>,
}

/// Velocities after one long step of the limp robot. Its acceleration is constant over a step, however long.
fn after_a_second<S: Simd>(
    simd: S,
    tree: &Tree,
    angles: &[f64; JOINTS],
    velocities: &[f64; JOINTS],
) -> Column {
    let angles = spread(simd, angles);
    let mut state = Joints { angles, velocities: spread(simd, velocities), targets: angles };
    let mut factor = Factor::new(simd);
    let mut whitened = [splat(simd, 0.0); JOINTS];
    dynamics::smooth(simd, tree, &poses(simd, tree, &angles), &state, 1.0, &mut factor, &mut whitened);
    dynamics::recover(simd, tree, &mut factor, &whitened, &mut state.velocities);
    Column::from_fn(|i, _| state.velocities[i][LANE])
}

#[test]
#[ignore = "asks MuJoCo: run `just referee`"]
fn inertia_and_velocity_dependent_forces_are_mujocos() {
    let mut random = Random::new(2);
    let tree = limp(&random.robot);
    let states: Vec<_> = (0..1000).map(|_| (random.posture(), random.velocities())).collect();
    let answer: Vec<Dynamics> = Python::start().ask("dynamics", &states);
    assert_eq!(answer.len(), states.len());
    let mut inertias = Bound::new("entries of the inertia, relative to the roots of their diagonals", 1e-9);
    let mut biases = Bound::new("velocity-dependent forces, relative to the largest of a state", 1e-9);
    let mut strict = Bound::new("velocity-dependent forces, relative in the kinetic metric", 1e-9);
    for ((angles, velocities), seen) in states.iter().zip(&answer) {
        let (inverse, after) = dispatch!(Level::new(), simd => (
            inverse_of_factored(simd, &tree, angles, 1.0),
            after_a_second(simd, &tree, angles, velocities),
        ));
        let expected = Square::from_row_slice(&seen.inertia);
        let inertia = inverse.try_inverse().unwrap();
        for (i, j) in (0..JOINTS).flat_map(|i| (0..JOINTS).map(move |j| (i, j))) {
            let scale = (expected[(i, i)] * expected[(j, j)]).sqrt();
            inertias.take((inertia[(i, j)] - expected[(i, j)]).abs() / scale);
        }
        let bias = inertia * (Column::from(*velocities) - after);
        let expected_bias = Column::from_row_slice(&seen.bias);
        biases.take((bias - expected_bias).amax() / expected_bias.amax());
        let length = |force: &Column| force.dot(&(inverse * force)).sqrt();
        strict.take(length(&(bias - expected_bias)) / length(&expected_bias));
    }
    inertias.hold();
    biases.hold();
    strict.hold();
}
