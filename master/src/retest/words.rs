//! Conditions, values and directions in words.

use selftalk_sim::behaviours::{Bound, Condition, Quantity};
use selftalk_sim::physics::Observation;
use selftalk_sim::scene;

/// A direction in which less than this is missing is not named, m.
const NEAR: f64 = 0.01;

/// A value as people want it, with its unit.
pub(super) fn number(quantity: Quantity, value: f64) -> String {
    match quantity {
        Quantity::Touches => format!("{value:.0}"),
        Quantity::Extension | Quantity::Alignment => format!("{value:.3}"),
        Quantity::PalmToTop | Quantity::GripToObject | Quantity::Height | Quantity::ObjectToTarget => {
            format!("{value:.3} m")
        }
    }
}

/// A condition, and for a distance that is too long in which direction.
pub(super) fn in_words(condition: &Condition, seen: Option<(&Observation, [f64; 3])>) -> String {
    let Condition { quantity, value, bound } = *condition;
    let (name, shown) = (quantity.name(), number(quantity, value));
    match bound {
        Bound::AtLeast(bound) => format!("{shown} of {bound} {name}"),
        _ if condition.holds() => format!("{name} {shown} ok"),
        Bound::Above(bound) => format!("{name} {shown} (goal {bound})"),
        Bound::Below(bound) => {
            let way = seen.map(|(seen, target)| way(quantity, seen, target)).unwrap_or_default();
            format!("{name} {shown} (goal {bound}{way})")
        }
    }
}

/// In which directions something is too far away.
fn way(quantity: Quantity, seen: &Observation, target: [f64; 3]) -> String {
    let words = apart(quantity, seen, target).map(directions).unwrap_or_default();
    if words.is_empty() { words } else { format!("; {words}") }
}

/// From where a thing should be to where it is; none for what is no distance.
pub(super) fn apart(quantity: Quantity, seen: &Observation, target: [f64; 3]) -> Option<[f64; 3]> {
    let [x, y, z] = seen.object;
    let (goal, thing): ([f64; 3], [f64; 3]) = match quantity {
        Quantity::PalmToTop => ([x, y, z + scene::OBJECT_RADIUS], seen.palm),
        Quantity::GripToObject => {
            let sum = |axis: usize| seen.thumb_tip[axis] + seen.little_tip[axis] + seen.palm[axis];
            (seen.object, [0, 1, 2].map(|axis| sum(axis) / 3.0))
        }
        Quantity::ObjectToTarget => (target, seen.object),
        Quantity::Extension | Quantity::Alignment | Quantity::Touches | Quantity::Height => return None,
    };
    Some([0, 1, 2].map(|axis| thing[axis] - goal[axis]))
}

/// Directions along the axes of the root frame in words: x backward, y to the robot's right, z up.
pub(super) fn directions(way: [f64; 3]) -> String {
    let names = [("far back", "far ahead"), ("far right", "far left"), ("high", "low")];
    let off = way.into_iter().zip(names).filter(|(by, _)| by.abs() > NEAR);
    let words =
        off.map(|(by, (more, less))| format!("{:.3} too {}", by.abs(), if by > 0.0 { more } else { less }));
    words.collect::<Vec<_>>().join(", ")
}
