//! GRASP: the fingers close around the object.

use super::goal::{Condition, Quantity, reached};
use super::{Judgement, View, near, unit};
use crate::experiment::Grasp;

pub(super) fn conditions(settings: &Grasp, view: &View<'_>) -> [Condition; 2] {
    let (touches, enough) = (f64::from(view.touches()), f64::from(settings.goal_touches));
    [
        Condition::below(Quantity::GripToObject, view.grip_to_object(), settings.goal_distance),
        Condition::at_least(Quantity::Touches, touches, enough),
    ]
}

pub(super) fn judge(settings: &Grasp, view: &View<'_>) -> Judgement {
    let conditions = conditions(settings, view);
    let [distance, touches] = conditions.map(|condition| condition.value);
    let touching =
        if settings.goal_touches == 0 { 1.0 } else { unit(touches / f64::from(settings.goal_touches)) };
    let closed = unit(view.flexion() / settings.full_flexion);
    let (near_weight, flexion_weight) = (settings.near_weight, settings.flexion_weight);
    Judgement {
        reward: near_weight * near(&settings.near, distance)
            + flexion_weight * closed
            + (1.0 - near_weight - flexion_weight) * touching,
        goal: reached(&conditions),
    }
}
