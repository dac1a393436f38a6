//! The range of every value of an experiment file.

use std::fmt::Display;
use std::ops::RangeInclusive;

use super::{Added, Experiment, Near, Problem};

/// Checks all values, in the order of the file.
pub(super) fn check(experiment: &Experiment) -> Result<(), Problem> {
    let e = experiment;
    name(&e.name)?;
    at_most("seed", e.seed, i64::MAX as u64)?;
    within("replications", e.replications, 1..=10_000)?;
    within("generations", e.generations, 1..=10_000_000)?;
    evolution(e)?;
    within("controller.weight_range", e.controller.weight_range, 1e-3..=1e3)?;
    within("controller.slope", e.controller.slope, 1e-3..=1e3)?;
    within("controller.position_scale", e.controller.position_scale, 1e-3..=10.0)?;
    within("controller.position_limit", e.controller.position_limit, 1e-3..=1e3)?;
    within("physics.substeps", e.physics.substeps, 4..=50)?;
    within("physics.sweeps", e.physics.sweeps, 1..=1000)?;
    within("physics.friction", e.physics.friction, 0.0..=10.0)?;
    within("scene.areas_x", e.scene.areas_x, -1.0..=0.0)?;
    within("scene.areas_y", e.scene.areas_y, -1.0..=1.0)?;
    within("scene.areas_distance", e.scene.areas_distance, 0.0..=0.5)?;
    within("scene.target_front", e.scene.target_front, 0.0..=1.0)?;
    within("scene.target_side", e.scene.target_side, 0.0..=1.0)?;
    within("scene.target_height", e.scene.target_height, 0.0..=1.0)?;
    within("scene.object_jitter", e.scene.object_jitter, 0.0..=0.1)?;
    within("scene.grasp_jitter_share", e.scene.grasp_jitter_share, 0.0..=1.0)?;
    within("scene.target_jitter", e.scene.target_jitter, 0.0..=0.1)?;
    within("trials.hold", e.trials.hold, 1..=shortest_trial(e))?;
    within("trials.lead_in", e.trials.lead_in, 0..=100_000)?;
    within("trials.goal_share", e.trials.goal_share, 0.0..=1.0)?;
    within("trials.wrong_focus", e.trials.wrong_focus, 0.0..=1.0)?;
    behaviours(e)?;
    integration(e)
}

fn evolution(experiment: &Experiment) -> Result<(), Problem> {
    let e = &experiment.evolution;
    within("evolution.population", e.population, 1..=100_000)?;
    if !(1..=e.population).contains(&e.parents) {
        let allowed = format!("between 1 and {} (evolution.population)", e.population);
        return Err(value("evolution.parents", e.parents, allowed));
    }
    if u64::from(e.parents) * u64::from(e.offspring) != u64::from(e.population) {
        let allowed =
            format!("such that parents x offspring is the population ({} x ? = {})", e.parents, e.population);
        return Err(value("evolution.offspring", e.offspring, allowed));
    }
    within("evolution.mutation", e.mutation, 0.0..=1.0)?;
    within("evolution.draws_every", e.draws_every, 1..=10_000_000)
}

fn behaviours(experiment: &Experiment) -> Result<(), Problem> {
    let Experiment { reach, open, grasp, transport, .. } = experiment;
    within("reach.steps", reach.steps, STEPS)?;
    within("reach.goal_distance", reach.goal_distance, DISTANCE)?;
    near("reach.near", &reach.near)?;
    within("reach.near_weight", reach.near_weight, 0.0..=1.0)?;
    within("reach.full_alignment", reach.full_alignment, -0.9..=1.0)?;
    within("open.steps", open.steps, STEPS)?;
    within("open.goal_distance", open.goal_distance, DISTANCE)?;
    within("open.goal_extension", open.goal_extension, 0.0..=1.0)?;
    within("open.goal_alignment", open.goal_alignment, -1.0..=1.0)?;
    within("open.full_extension", open.full_extension, 0.01..=1.0)?;
    within("open.full_alignment", open.full_alignment, -0.9..=1.0)?;
    near("open.near", &open.near)?;
    within("grasp.steps", grasp.steps, STEPS)?;
    within("grasp.goal_distance", grasp.goal_distance, DISTANCE)?;
    within("grasp.goal_touches", grasp.goal_touches, 0..=6)?;
    within("grasp.goal_height", grasp.goal_height, 0.0..=1.0)?;
    within("grasp.height_weight", grasp.height_weight, 0.0..=1.0)?;
    near("grasp.near", &grasp.near)?;
    within("grasp.near_weight", grasp.near_weight, 0.0..=1.0)?;
    if !(0.0..=1.0 - grasp.near_weight).contains(&grasp.flexion_weight) {
        let allowed = format!("between 0 and {} (1 - grasp.near_weight)", 1.0 - grasp.near_weight);
        return Err(value("grasp.flexion_weight", grasp.flexion_weight, allowed));
    }
    within("grasp.full_flexion", grasp.full_flexion, 0.01..=1.0)?;
    within("move.steps", transport.steps, STEPS)?;
    within("move.goal_distance", transport.goal_distance, DISTANCE)?;
    near("move.near", &transport.near)?;
    within("move.near_weight", transport.near_weight, 0.0..=1.0)?;
    within("move.held_touches", transport.held_touches, 0..=6)?;
    within("move.held_height", transport.held_height, 0.0..=1.0)
}

fn integration(experiment: &Experiment) -> Result<(), Problem> {
    let Experiment { move_to_target, caretaker, ancestors, .. } = experiment;
    within("move_to_target.steps", move_to_target.steps, STEPS)?;
    within("move_to_target.goal_distance", move_to_target.goal_distance, DISTANCE)?;
    within("move_to_target.goal_share", move_to_target.goal_share, 0.0..=1.0)?;
    if !(0.0..=1.0 - move_to_target.goal_share).contains(&move_to_target.lift_share) {
        let most = 1.0 - move_to_target.goal_share;
        let allowed = format!("between 0 and {most} (1 - move_to_target.goal_share)");
        return Err(value("move_to_target.lift_share", move_to_target.lift_share, allowed));
    }
    within("caretaker.anticipation_share", caretaker.anticipation_share, 0.0..=1.0)?;
    within("caretaker.soon", caretaker.soon, 1..=100_000)?;
    within("caretaker.early", caretaker.early, caretaker.soon..=100_000)?;
    within("caretaker.early_reward", caretaker.early_reward, 0.0..=1.0)?;
    if !ancestors.genotypes.is_empty() && !ancestors.evolve && experiment.controller.added == Added::None {
        let allowed = "\"internal\" or \"speech\" with ancestors, whose genes stay as they are unless ancestors.evolve is true";
        return Err(value("controller.added", "\"none\"", allowed));
    }
    Ok(())
}

const STEPS: RangeInclusive<u32> = 1..=100_000;
const DISTANCE: RangeInclusive<f64> = 1e-3..=10.0;

fn shortest_trial(e: &Experiment) -> u32 {
    let lengths = [e.reach.steps, e.open.steps, e.grasp.steps, e.transport.steps, e.move_to_target.steps];
    lengths.into_iter().fold(u32::MAX, u32::min).max(1)
}

fn near(key: &str, near: &Near) -> Result<(), Problem> {
    within(&format!("{key}.full"), near.full, 0.0..=10.0)?;
    within(&format!("{key}.wide"), near.wide, DISTANCE)?;
    within(&format!("{key}.narrow"), near.narrow, DISTANCE)
}

fn name(name: &str) -> Result<(), Problem> {
    let allowed = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    if (1..=64).contains(&name.len()) && name.chars().all(allowed) {
        return Ok(());
    }
    Err(value("name", format!("{name:?}"), "1 to 64 letters, digits, `-`, `_` or `.`"))
}

fn at_most(key: &str, found: u64, most: u64) -> Result<(), Problem> {
    if found <= most { Ok(()) } else { Err(value(key, found, format!("at most {most}"))) }
}

/// NaN lies in no range.
fn within<T: PartialOrd + Display>(key: &str, found: T, range: RangeInclusive<T>) -> Result<(), Problem> {
    if range.contains(&found) {
        return Ok(());
    }
    Err(value(key, found, format!("between {} and {}", range.start(), range.end())))
}

fn value(key: &str, found: impl Display, allowed: impl Into<String>) -> Problem {
    Problem::Value { key: key.to_owned(), value: found.to_string(), allowed: allowed.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_passes() {
        assert_eq!(check(&Experiment::default()), Ok(()));
    }

    #[test]
    fn offspring_must_fill_the_population() {
        let mut e = Experiment::default();
        e.evolution.offspring = 4;
        let message = check(&e).unwrap_err().to_string();
        assert!(message.contains("20 x ? = 100"), "{message}");
    }

    #[test]
    fn not_a_number_is_refused() {
        let mut e = Experiment::default();
        e.physics.friction = f64::NAN;
        assert_eq!(check(&e).unwrap_err().to_string(), "physics.friction = NaN: must be between 0 and 10");
    }

    #[test]
    fn names_stay_usable_on_a_command_line() {
        for bad in ["", "a b", "ä", "a/b"] {
            let e = Experiment { name: bad.to_owned(), ..Experiment::default() };
            assert!(check(&e).is_err(), "{bad:?}");
        }
    }
}
