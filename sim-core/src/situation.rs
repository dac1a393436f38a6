//! What a trial asks for, and where robot, object and target are when it begins (paper, sections II.A, II.C and III.E).

use rand::RngExt;

use crate::behaviours::Behaviour;
use crate::experiment::{Experiment, Speaks, Task};
use crate::scene;
use crate::stream::{Purpose, StreamKey};

/// Selects the random positions of object and target: all genotypes that are evaluated with the same draw face the
/// same ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Draw {
    /// Replication, counted from 0.
    pub replication: u32,
    /// Generation in which the positions were drawn, counted from 0.
    pub generation: u32,
}

/// Fresh draws of a kind, and where the kinds begin: beyond any generation that an experiment can run for.
const FRESH: u32 = 1 << 30;
const VALIDATION: u32 = FRESH;
const TEST: u32 = 2 * FRESH;

impl Draw {
    /// A draw that no evolution uses, for choosing between individuals. `number` counts from 0 to 2^30 - 1.
    #[must_use]
    pub const fn validation(number: u32) -> Self {
        Self { replication: 0, generation: VALIDATION + number % FRESH }
    }

    /// A draw that neither an evolution nor a choice between individuals uses, for reporting how good they are.
    /// `number` counts from 0 to 2^30 - 1.
    #[must_use]
    pub const fn test(number: u32) -> Self {
        Self { replication: 0, generation: TEST + number % FRESH }
    }
}

/// Which trial.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Case {
    /// One by which individuals are selected, or like those.
    Drawn {
        /// Object and target positions.
        draw: Draw,
        /// Trial, counted from 0.
        trial: u32,
    },
    /// One of generalisation: MOVE-TO-TARGET with the object at a place of a grid (paper, section III.E).
    Grid {
        /// Place and initial posture: posture `number % 4`, places row by row. Counted from 0.
        number: u32,
    },
}

/// Places along each side of the grid of generalisation; paper: 7.
const GRID: u32 = 7;
/// Length of that grid's sides, m; paper: 0.35.
const GRID_SIDE: f64 = 0.35;
/// Initial postures of a behaviour.
const POSTURES: u32 = 4;

impl Case {
    /// Trials of generalisation: 7 x 7 places with 4 initial postures each.
    pub const GRID_TRIALS: u32 = GRID * GRID * POSTURES;
}

/// Trials of an evaluation: four for each elementary action, or eight of MOVE-TO-TARGET (paper, section II.C).
pub(crate) const fn trials(task: Task) -> u32 {
    match task {
        Task::Elementary => 16,
        Task::MoveToTarget => 8,
    }
}

impl Behaviour {
    /// The behaviour a trial asks for: in the first phase trials 0 to 3 REACH, 4 to 7 OPEN, 8 to 11 GRASP, 12 to 15
    /// MOVE.
    #[must_use]
    pub fn of_trial(task: Task, trial: u32) -> Self {
        match task {
            Task::Elementary => Self::ELEMENTARY[(trial / 4) as usize % Self::ELEMENTARY.len()],
            Task::MoveToTarget => Self::MoveToTarget,
        }
    }

    /// The area in which a trial's object is placed: 0 to 3 for front, back, left and right. In MOVE-TO-TARGET two
    /// trials after each other, one with an even and one with an odd number, have the same.
    #[must_use]
    pub fn area_of_trial(task: Task, trial: u32) -> usize {
        let area = match task {
            Task::Elementary => trial,
            Task::MoveToTarget => trial / 2,
        };
        area as usize % scene::AREA_DIRECTIONS.len()
    }
}

/// A trial before it begins. Root frame, metres.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Situation {
    pub(crate) behaviour: Behaviour,
    /// Which of the behaviour's initial postures.
    pub(crate) posture: usize,
    /// Where an object on the table stands.
    pub(crate) object: [f64; 2],
    pub(crate) target: [f64; 3],
    /// Whether the caretaker speaks.
    pub(crate) caretaker: bool,
    /// Control steps under the label of the action before this one.
    pub(crate) lead_in: u32,
}

impl Situation {
    /// The situation of a case, whose trial is one of the task's.
    pub(crate) fn new(experiment: &Experiment, case: Case) -> Self {
        match case {
            Case::Drawn { draw, trial } => Self::drawn(experiment, draw, trial),
            Case::Grid { number } => Self::on_grid(experiment, number),
        }
    }

    fn drawn(experiment: &Experiment, Draw { replication, generation }: Draw, trial: u32) -> Self {
        let (seed, task, settings) = (experiment.seed, experiment.task, &experiment.scene);
        let (behaviour, area) = (Behaviour::of_trial(task, trial), Behaviour::area_of_trial(task, trial));
        let purpose = Purpose::TrialDraw;
        let mut stream = StreamKey { seed, replication, generation, purpose, index: trial }.stream();
        let mut jitter = |size: f64| size * (2.0 * stream.random::<f64>() - 1.0);
        let share = if behaviour == Behaviour::Grasp { settings.grasp_jitter_share } else { 1.0 };
        let [front, side] = scene::AREA_DIRECTIONS[area];
        let object = [
            settings.areas_x + front * settings.areas_distance + jitter(settings.object_jitter * share),
            settings.areas_y + side * settings.areas_distance + jitter(settings.object_jitter * share),
        ];
        // Both target areas come up equally often in each behaviour, and in MOVE-TO-TARGET with each of the object's.
        // There postures are crossed with areas as far as the trials go.
        let (side, posture) = match task {
            Task::Elementary => (area, area),
            Task::MoveToTarget => {
                let odd = (trial % 2) as usize;
                (area + odd, (area + 2 * odd) % POSTURES as usize)
            }
        };
        let target = target(experiment, side, &mut jitter);
        let lead_in = match behaviour.before() {
            Some(_) => stream.random_range(0..=experiment.trials.lead_in),
            None => 0,
        };
        let caretaker = behaviour == Behaviour::MoveToTarget && experiment.caretaker.speaks.in_trial(trial);
        Self { behaviour, posture, object, target, caretaker, lead_in }
    }

    fn on_grid(experiment: &Experiment, number: u32) -> Self {
        let settings = &experiment.scene;
        let (place, posture) = (number / POSTURES % (GRID * GRID), number % POSTURES);
        let along = |step: u32| GRID_SIDE * (f64::from(step) / f64::from(GRID - 1) - 0.5);
        let object = [settings.areas_x + along(place / GRID), settings.areas_y + along(place % GRID)];
        let purpose = Purpose::Generalisation;
        let key = StreamKey { seed: experiment.seed, replication: 0, generation: 0, purpose, index: number };
        let mut stream = key.stream();
        let jitter = |size: f64| size * (2.0 * stream.random::<f64>() - 1.0);
        Self {
            behaviour: Behaviour::MoveToTarget,
            posture: posture as usize,
            object,
            target: target(experiment, (place + posture) as usize, jitter),
            caretaker: experiment.caretaker.speaks == Speaks::Always,
            lead_in: 0,
        }
    }
}

/// A point in the target area to the left or to the right.
fn target(experiment: &Experiment, side: usize, mut jitter: impl FnMut(f64) -> f64) -> [f64; 3] {
    let settings = &experiment.scene;
    let side = scene::TARGET_DIRECTIONS[side % 2] * settings.target_side;
    [-settings.target_front, side, scene::TABLE + settings.target_height]
        .map(|centre| centre + jitter(settings.target_jitter))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn integrated() -> Experiment {
        let overrides = ["task=move-to-target", "caretaker.speaks=even"].map(str::to_owned);
        Experiment::from_toml("x", "", &overrides).unwrap()
    }

    #[test]
    fn no_evolution_gets_as_far_as_the_fresh_draws() {
        let longest = |generations| Experiment::from_toml("x", &format!("generations = {generations}"), &[]);
        assert!(longest(10_000_000).is_ok());
        assert!(longest(Draw::validation(0).generation).is_err());
        assert!(Draw::validation(FRESH - 1).generation < Draw::test(0).generation);
        assert!(Draw::test(0).generation < Draw::test(FRESH - 1).generation);
    }

    #[test]
    fn trials_with_the_caretaker_and_without_have_the_same_areas_targets_and_postures() {
        let experiment = integrated();
        let draw = Draw { replication: 1, generation: 2 };
        let all: Vec<Situation> =
            (0..8).map(|trial| Situation::new(&experiment, Case::Drawn { draw, trial })).collect();
        for parity in 0..2 {
            let half: Vec<&Situation> = all.iter().skip(parity).step_by(2).collect();
            assert!(half.iter().all(|situation| situation.caretaker == (parity == 0)));
            let mut postures: Vec<usize> = half.iter().map(|situation| situation.posture).collect();
            postures.sort_unstable();
            assert_eq!(postures, [0, 1, 2, 3]);
            assert_eq!(half.iter().filter(|situation| situation.target[1] > 0.0).count(), 2);
        }
        for pair in all.chunks(2) {
            let [x, y] = [0, 1].map(|axis| (pair[0].object[axis] - pair[1].object[axis]).abs());
            assert!(x <= 0.04 && y <= 0.04, "one area");
            assert!(pair[0].target[1] * pair[1].target[1] < 0.0, "both targets");
        }
    }

    #[test]
    fn lead_ins_are_drawn_up_to_the_longest_and_change_no_position() {
        let lengthy = ["trials.lead_in=3".to_owned()];
        let [plain, linked] = [&[][..], &lengthy].map(|set| Experiment::from_toml("x", "", set).unwrap());
        let mut seen = [0; 4];
        for generation in 0..50 {
            let draw = Draw { replication: 0, generation };
            for trial in 0..16 {
                let [plain, linked] =
                    [&plain, &linked].map(|e| Situation::new(e, Case::Drawn { draw, trial }));
                assert_eq!(plain, Situation { lead_in: 0, ..linked.clone() });
                match linked.behaviour {
                    Behaviour::Reach => assert_eq!(linked.lead_in, 0),
                    _ => seen[linked.lead_in as usize] += 1,
                }
            }
        }
        assert!(seen.iter().all(|times| *times > 100), "{seen:?} of 600");
    }

    #[test]
    fn the_grid_covers_its_square_with_every_posture() {
        let experiment = integrated();
        let all: Vec<Situation> =
            (0..Case::GRID_TRIALS).map(|number| Situation::new(&experiment, Case::Grid { number })).collect();
        assert_eq!(all.len(), 196);
        let close = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).abs() < 1e-12 && (a[1] - b[1]).abs() < 1e-12;
        assert!(close(all[0].object, [-0.475, -0.275]));
        assert!(close(all[4].object, [-0.475, -0.275 + 0.35 / 6.0]));
        assert!(close(all[195].object, [-0.125, 0.075]));
        for place in all.chunks(4) {
            assert_eq!([0, 1, 2, 3].map(|at| place[at].posture), [0, 1, 2, 3]);
            assert!(place.iter().all(|situation| situation.object == place[0].object));
            assert_eq!(place.iter().filter(|situation| situation.target[1] > 0.0).count(), 2);
        }
        assert!(all.iter().all(|situation| !situation.caretaker));
    }
}
