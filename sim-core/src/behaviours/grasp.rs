//! GRASP: the fingers close around the object.

use super::{Judgement, View, near, unit};
use crate::experiment::Grasp;

pub(super) fn judge(settings: &Grasp, view: &View<'_>) -> Judgement {
    let distance = view.grip_to_object();
    let touches = view.touches();
    let touching = if settings.goal_touches == 0 {
        1.0
    } else {
        unit(f64::from(touches) / f64::from(settings.goal_touches))
    };
    let closed = unit(view.flexion() / settings.full_flexion);
    let (near_weight, flexion_weight) = (settings.near_weight, settings.flexion_weight);
    Judgement {
        reward: near_weight * near(&settings.near, distance)
            + flexion_weight * closed
            + (1.0 - near_weight - flexion_weight) * touching,
        goal: distance < settings.goal_distance && touches >= settings.goal_touches,
    }
}
