//! GRASP: the fingers close around the object.

use super::goal::{Condition, Quantity, reached};
use super::{Judgement, View, near, unit};
use crate::experiment::Grasp;

pub(super) fn conditions(settings: &Grasp, view: &View<'_>) -> Vec<Condition> {
    closed(settings, view).into_iter().chain(raised(settings, view)).collect()
}

/// What the paper asks for.
fn closed(settings: &Grasp, view: &View<'_>) -> [Condition; 2] {
    let (touches, enough) = (f64::from(view.touches()), f64::from(settings.goal_touches));
    [
        Condition::below(Quantity::GripToObject, view.grip_to_object(), settings.goal_distance),
        Condition::at_least(Quantity::Touches, touches, enough),
    ]
}

/// That the grip holds: fingers that only press on the object cannot raise it.
fn raised(settings: &Grasp, view: &View<'_>) -> Option<Condition> {
    let asked = settings.goal_height > 0.0;
    asked.then(|| Condition::above(Quantity::Height, view.height(), settings.goal_height))
}

pub(super) fn judge(settings: &Grasp, view: &View<'_>) -> Judgement {
    let (closed, raised) = (closed(settings, view), raised(settings, view));
    let [distance, touches] = closed.map(|condition| condition.value);
    let touching =
        if settings.goal_touches == 0 { 1.0 } else { unit(touches / f64::from(settings.goal_touches)) };
    let flexed = unit(view.flexion() / settings.full_flexion);
    let (near_weight, flexion_weight) = (settings.near_weight, settings.flexion_weight);
    let closing = near_weight * near(&settings.near, distance)
        + flexion_weight * flexed
        + (1.0 - near_weight - flexion_weight) * touching;
    let reward = match &raised {
        // Only while the object is felt, so that throwing it up is worth nothing.
        Some(height) => {
            let weight = settings.height_weight;
            (1.0 - weight) * closing + weight * touching * unit(height.value / settings.goal_height)
        }
        None => closing,
    };
    Judgement { reward, goal: reached(&closed) && raised.is_none_or(|height| height.holds()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::Observation;
    use crate::robot::{RobotModel, joint};
    use crate::scene;

    /// A hand with closed fingers around an object at a height, felt by some sensors.
    fn judged(settings: &Grasp, height: f64, touches: usize) -> Judgement {
        let robot = RobotModel::icub().unwrap();
        let mut angles = robot.joints.each_ref().map(|joint| joint.angle(0.5));
        for joint in joint::FLEXION {
            angles[joint] = robot.joints[joint].angle(0.9);
        }
        let object = [-0.3, -0.1, scene::OBJECT_STANDING + height];
        let observation = Observation {
            angles,
            palm: object,
            palm_normal: [0.0, 0.0, -1.0],
            thumb_tip: object,
            little_tip: object,
            object,
            orientation: [1.0, 0.0, 0.0, 0.0],
            touch: std::array::from_fn(|sensor| sensor < touches),
        };
        judge(settings, &View { robot: &robot, observation: &observation, target: [0.0; 3] })
    }

    #[test]
    fn the_papers_goal_asks_for_no_height() {
        let on_the_table = judged(&Grasp::default(), -1e-5, 3);
        assert!(on_the_table.goal && (on_the_table.reward - 1.0).abs() < 1e-12);
        assert!(!judged(&Grasp::default(), 0.0, 2).goal);
    }

    #[test]
    fn a_grip_that_has_to_hold_is_rewarded_for_raising_what_it_feels() {
        let settings = Grasp { goal_height: 0.01, ..Grasp::default() };
        let [table, halfway, raised] = [0.0, 0.005, 0.011].map(|height| judged(&settings, height, 3));
        assert_eq!([table.goal, halfway.goal, raised.goal], [false, false, true]);
        let expected = [0.6, 0.8, 1.0];
        for (judgement, expected) in [table, halfway, raised].iter().zip(expected) {
            assert!((judgement.reward - expected).abs() < 1e-12, "{judgement:?}");
        }
        let thrown = judged(&settings, 0.1, 0);
        assert!(!thrown.goal && thrown.reward < table.reward, "{thrown:?}");
    }
}
