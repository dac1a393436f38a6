//! What the robot and the things around it look like at a moment: the shapes that the simulator has, in Foxglove's
//! primitives.

use nalgebra::{Matrix3, Point3, Rotation3, UnitQuaternion, Vector3};

use super::foxglove::packed_element_field::NumericType;
use super::foxglove::{
    Color, CubePrimitive, CylinderPrimitive, PackedElementField, PointCloud, Pose, Quaternion, SceneEntity,
    SceneUpdate, SpherePrimitive, Vector3 as Vector,
};
use super::{ROOT, timestamp};
use crate::replay::shapes::{self, Shape, Tint};
use crate::replay::{Moment, Recording};

/// The scene at a moment. It is complete each time: a program that jumps to a moment shows nothing of what was before.
pub(super) fn at(recording: &Recording, moment: &Moment, time: u64) -> SceneUpdate {
    let entity = |(id, shapes): (&str, Vec<(Shape, Tint)>)| {
        let mut entity = SceneEntity {
            timestamp: timestamp(time),
            frame_id: ROOT.to_owned(),
            id: id.to_owned(),
            ..SceneEntity::default()
        };
        for (shape, tint) in shapes {
            add(&mut entity, shape, colour(tint));
        }
        entity
    };
    SceneUpdate { entities: shapes::at(recording, moment).into_iter().map(entity).collect() }
}

fn add(entity: &mut SceneEntity, shape: Shape, color: Option<Color>) {
    match shape {
        Shape::Ball { centre, radius } => entity.spheres.push(ball(centre, radius, color)),
        Shape::Capsule { ends: [a, b], radius } => {
            let axis = Vector3::from(b) - Vector3::from(a);
            let turn = UnitQuaternion::rotation_between(&Vector3::z(), &axis);
            // Straight down there is no shortest turn.
            let turn = turn.unwrap_or_else(|| UnitQuaternion::new_normalize([0.0, 1.0, 0.0, 0.0].into()));
            let middle = nalgebra::center(&Point3::from(a), &Point3::from(b));
            entity.cylinders.push(CylinderPrimitive {
                pose: pose(middle.into(), turn),
                size: Some(vector([2.0 * radius, 2.0 * radius, axis.norm()])),
                bottom_scale: 1.0,
                top_scale: 1.0,
                color,
            });
            entity.spheres.extend([a, b].map(|end| ball(end, radius, color)));
        }
        Shape::Box { corners } => {
            let edge = |corner: usize| Vector3::from(corners[corner]) - Vector3::from(corners[0]);
            let edges = [edge(1), edge(2), edge(4)];
            let axes = Matrix3::from_columns(&edges.map(|edge| edge.normalize()));
            let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
            let middle = nalgebra::center(&Point3::from(corners[0]), &Point3::from(corners[7]));
            entity.cubes.push(CubePrimitive {
                pose: pose(middle.into(), turn),
                size: Some(vector(edges.map(|edge| edge.norm()))),
                color,
            });
        }
    }
}

fn ball(centre: [f64; 3], radius: f64, color: Option<Color>) -> SpherePrimitive {
    let pose = pose(centre, UnitQuaternion::identity());
    SpherePrimitive { pose, size: Some(vector([2.0 * radius; 3])), color }
}

fn pose(place: [f64; 3], turn: UnitQuaternion<f64>) -> Option<Pose> {
    Some(Pose { position: Some(vector(place)), orientation: Some(quaternion(turn)) })
}

pub(super) fn vector([x, y, z]: [f64; 3]) -> Vector {
    Vector { x, y, z }
}

pub(super) fn quaternion(turn: UnitQuaternion<f64>) -> Quaternion {
    Quaternion { x: turn.i, y: turn.j, z: turn.k, w: turn.w }
}

fn colour(tint: Tint) -> Option<Color> {
    let ([r, g, b], a) = (tint.rgb().map(|part| f64::from(part) / 255.0), tint.opacity());
    Some(Color { r, g, b, a })
}

/// Points per metre on the shapes.
const DENSITY: f64 = 250.0;
/// Bytes of a point: three coordinates and a colour.
const STRIDE: u32 = 16;

/// The same as a cloud of points, for programs that know no shapes. The table is left out.
pub(super) fn points(recording: &Recording, moment: &Moment, time: u64) -> PointCloud {
    let mut data = Vec::new();
    let shapes = shapes::at(recording, moment).into_iter().filter(|(id, _)| *id != "table");
    for (shape, tint) in shapes.flat_map(|(_, shapes)| shapes) {
        for point in samples(shape) {
            data.extend(point.map(|coordinate| coordinate as f32).iter().flat_map(|part| part.to_le_bytes()));
            data.extend(tint.rgb());
            data.push(255);
        }
    }
    let field = |name: &str, offset: u32, r#type: NumericType| PackedElementField {
        name: name.to_owned(),
        offset,
        r#type: r#type.into(),
    };
    PointCloud {
        timestamp: timestamp(time),
        frame_id: ROOT.to_owned(),
        pose: pose([0.0; 3], UnitQuaternion::identity()),
        point_stride: STRIDE,
        fields: vec![
            field("x", 0, NumericType::Float32),
            field("y", 4, NumericType::Float32),
            field("z", 8, NumericType::Float32),
            field("red", 12, NumericType::Uint8),
            field("green", 13, NumericType::Uint8),
            field("blue", 14, NumericType::Uint8),
            field("alpha", 15, NumericType::Uint8),
        ],
        data,
    }
}

/// Points of a shape: along the axis of a capsule, the corners of a box, the ends of a ball.
fn samples(shape: Shape) -> Vec<[f64; 3]> {
    match shape {
        Shape::Ball { centre: [x, y, z], radius: r } => {
            vec![
                [x, y, z],
                [x + r, y, z],
                [x - r, y, z],
                [x, y + r, z],
                [x, y - r, z],
                [x, y, z + r],
                [x, y, z - r],
            ]
        }
        Shape::Capsule { ends: [a, b], .. } => {
            let (a, b) = (Vector3::from(a), Vector3::from(b));
            let count = ((b - a).norm() * DENSITY).ceil().max(1.0) as u32;
            (0..=count).map(|at| a.lerp(&b, f64::from(at) / f64::from(count)).into()).collect()
        }
        Shape::Box { corners } => corners.to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::replay::tests::recording;

    #[test]
    fn a_cylinder_lies_along_its_capsule_s_axis() {
        let mut entity = SceneEntity::default();
        for ends in [[[0.1, 0.2, 0.3], [0.4, -0.1, 0.3]], [[0.0, 0.0, 0.2], [0.0, 0.0, 0.1]]] {
            add(&mut entity, Shape::Capsule { ends, radius: 0.02 }, None);
            let cylinder = entity.cylinders.last().unwrap();
            let (pose, size) = (cylinder.pose.as_ref().unwrap(), cylinder.size.as_ref().unwrap());
            let Quaternion { x, y, z, w } = pose.orientation.unwrap();
            let turn = UnitQuaternion::new_normalize(nalgebra::Quaternion::new(w, x, y, z));
            let position = pose.position.unwrap();
            let middle = Vector3::new(position.x, position.y, position.z);
            let end = middle + turn * Vector3::new(0.0, 0.0, size.z / 2.0);
            assert!((end - Vector3::from(ends[1])).norm() < 1e-9, "{ends:?}: {end}");
        }
    }

    #[test]
    fn the_palm_is_as_large_as_the_robot_has_it() {
        let recording = recording(&["reach.steps=3"], 0);
        let scene = at(&recording, &recording.moments[1], 0);
        let robot = scene.entities.iter().find(|entity| entity.id == "robot").unwrap();
        let half = selftalk_sim::robot::RobotModel::icub().unwrap().palm.half;
        let size = robot.cubes[0].size.unwrap();
        for (size, half) in [size.x, size.y, size.z].into_iter().zip(half.iter()) {
            assert!((size - 2.0 * half).abs() < 1e-9);
        }
    }

    #[test]
    fn a_cloud_has_its_points_in_full() {
        let recording = recording(&["reach.steps=3"], 0);
        let cloud = points(&recording, &recording.moments[1], 0);
        assert!(cloud.data.len() > 100 * STRIDE as usize);
        assert_eq!(cloud.data.len() % STRIDE as usize, 0);
    }
}
