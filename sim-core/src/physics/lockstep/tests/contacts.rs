//! What contacts may do to the object, and what happens to it without them.

use fearless_simd::{Level, Simd, dispatch};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use proptest::prelude::*;

use super::super::*;
use super::LANE;
use crate::behaviours::Starts;

fn lockstep<S: Simd>(simd: S) -> Lockstep<S> {
    let robot = RobotModel::icub().unwrap();
    let tree = Tree::new(&robot).unwrap();
    let landmarks = Landmarks::new(&robot, &tree);
    Lockstep::new(simd, tree, landmarks, &Physics::default())
}

/// Velocity, spin and orientation of an object that flies freely for half a second.
fn flight<S: Simd>(simd: S, velocity: [f64; 3], spin: [f64; 3]) -> [Vec<f64>; 3] {
    let mut engine = lockstep(simd);
    set(&mut engine.object.centre, LANE, [-1.0, 0.0, 50.0]);
    set(&mut engine.object.twist.linear, LANE, velocity);
    set(&mut engine.object.twist.angular, LANE, spin);
    for _ in 0..10 {
        engine.advance();
    }
    let orientation = engine.object.orientation.map(|part| part[LANE]).to_vec();
    [
        get(&engine.object.twist.linear, LANE).to_vec(),
        get(&engine.object.twist.angular, LANE).to_vec(),
        orientation,
    ]
}

/// The largest excess of a contact's friction over its cone, and the smallest normal impulse, N s, while a hand
/// around the object is driven to `shares` of the joints' ranges.
fn cone<S: Simd>(simd: S, start: usize, shares: &[f64; JOINTS]) -> (f64, f64) {
    let robot = RobotModel::icub().unwrap();
    let mut engine = lockstep(simd);
    engine.place(LANE, &Starts::shipped().unwrap().held[start].placement([0.0; 2]));
    engine.command(LANE, &std::array::from_fn(|i| robot.joints[i].angle(shares[i])));
    let (mut excess, mut smallest) = (f64::MIN, f64::MAX);
    for _ in 0..200 {
        engine.step();
        for candidate in 0..CANDIDATES {
            let impulse = engine.solver.impulse(candidate);
            let normal = impulse.normal[LANE];
            let friction = Vector3::from(get(&impulse.friction, LANE)).norm();
            excess = excess.max(friction - engine.settings.friction * normal);
            smallest = smallest.min(normal);
        }
    }
    (excess, smallest)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn the_free_object_keeps_its_momentum(
        velocity in prop::array::uniform3(-3.0..3.0_f64),
        spin in prop::array::uniform3(-10.0..10.0_f64),
    ) {
        let [after, spin_after, orientation] =
            dispatch!(Level::new(), simd => flight(simd, velocity, spin));
        let time = 10.0 * CONTROL_STEP;
        prop_assert!((after[0] - velocity[0]).abs() + (after[1] - velocity[1]).abs() < 1e-12, "{after:?}");
        prop_assert!((after[2] - velocity[2] + scene::GRAVITY * time).abs() < 1e-12, "{after:?}");
        for (now, then) in spin_after.iter().zip(spin) {
            prop_assert!((now - then).abs() < 1e-12, "{spin_after:?}");
        }
        let [w, x, y, z] = orientation[..] else { unreachable!("four parts") };
        let found = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        let expected = UnitQuaternion::from_scaled_axis(Vector3::from(spin) * time);
        prop_assert!(found.angle_to(&expected) < 0.02, "{}", found.angle_to(&expected));
    }

    #[test]
    fn contacts_push_and_their_friction_stays_within_its_cone(
        start in 0..4_usize,
        shares in prop::array::uniform20(0.0..1.0_f64),
    ) {
        let (excess, smallest) = dispatch!(Level::new(), simd => cone(simd, start, &shares));
        prop_assert!(excess < 1e-12, "{excess}");
        prop_assert!(smallest >= 0.0, "{smallest}");
    }
}
