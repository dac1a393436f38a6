//! What only this engine does.

use super::*;
use crate::behaviours::Starts;

#[test]
fn what_left_the_finite_numbers_is_seen_and_is_gone_with_the_next_trial() {
    let start = Starts::shipped().unwrap().held[0].placement([0.0; 2]);
    let mut engine = Rapier::new(&RobotModel::icub().unwrap(), &Physics::default()).unwrap();
    let course = |engine: &mut Rapier, placement: &Placement, targets: &[f64; JOINTS]| {
        engine.place(0, placement);
        engine.command(0, targets);
        engine.advance();
        engine.observe(0)
    };
    let healthy = course(&mut engine, &start, &start.targets);
    assert!(healthy.is_finite());
    for joint in [joint::TORSO_PITCH, joint::HAND, JOINTS - 1] {
        let mut targets = start.targets;
        targets[joint] = f64::NAN;
        assert!(!course(&mut engine, &start, &targets).is_finite());
        // It stays so, whatever is commanded.
        engine.command(0, &start.targets);
        engine.advance();
        assert!(!engine.observe(0).is_finite());
        assert_eq!(course(&mut engine, &start, &start.targets), healthy);
    }
    for broken in [
        Placement { object: [0.0, f64::NAN, 0.0], ..start.clone() },
        Placement { orientation: [f64::INFINITY; 4], ..start.clone() },
        Placement { angles: [f64::INFINITY; JOINTS], ..start.clone() },
    ] {
        assert!(!course(&mut engine, &broken, &start.targets).is_finite());
        assert_eq!(course(&mut engine, &start, &start.targets), healthy);
    }
}
