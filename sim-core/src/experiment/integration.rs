//! The sections of an experiment file that belong to the paper's second training phase (section III).

use serde::{Deserialize, Serialize};

use crate::genotype::Genotype;

/// What an individual is selected by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Task {
    /// REACH, OPEN, GRASP and MOVE, four trials each: the first phase.
    #[default]
    Elementary,
    /// MOVE-TO-TARGET, eight trials: the second phase.
    MoveToTarget,
}

/// Neurons that the second phase adds to the controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Added {
    /// None: the first phase.
    #[default]
    None,
    /// Four internal neurons: conditions C and LE.
    Internal,
    /// Four neurons that speak the labels of the elementary actions: conditions ST and LST.
    Speech,
}

/// In which trials of MOVE-TO-TARGET the caretaker speaks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Speaks {
    /// In none: conditions C and ST.
    #[default]
    Never,
    /// In those with even numbers: conditions LE and LST.
    Even,
    /// In all: no condition of the paper; to compare what robots do with the caretaker's labels and without.
    Always,
}

impl Speaks {
    /// Whether it speaks in a trial.
    #[must_use]
    pub const fn in_trial(self, trial: u32) -> bool {
        match self {
            Self::Never => false,
            Self::Even => trial.is_multiple_of(2),
            Self::Always => true,
        }
    }
}

/// The caretaker, who says which elementary action is due (paper, section III.C), and what it is worth to say so before
/// it does (paper, section III.D).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Caretaker {
    /// In which trials it speaks.
    pub speaks: Speaks,
    /// Share of the score that anticipation makes up in trials in which it speaks; above 0 in condition LST.
    pub anticipation_share: f64,
    /// A label that the robot has been saying for this many control steps or fewer when the caretaker comes to it is
    /// anticipated best; paper: 1 to 5 steps.
    pub soon: u32,
    /// One that it has been saying for longer, up to this many steps, is worth `early_reward`; paper: 6 to 20 steps.
    pub early: u32,
    /// What that is worth, as a share of the best.
    pub early_reward: f64,
}

impl Default for Caretaker {
    fn default() -> Self {
        Self { speaks: Speaks::Never, anticipation_share: 0.0, soon: 5, early: 20, early_reward: 0.3 }
    }
}

/// MOVE-TO-TARGET: a distant object is fetched and carried to the target (paper, section II.C).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MoveToTarget {
    /// Length of a trial in control steps.
    pub steps: u32,
    /// The goal: the object is closer than this to the target, in metres; paper: 0.06.
    pub goal_distance: f64,
    /// Share of the score that reaching the goal gives.
    pub goal_share: f64,
    /// Share that lifting the object gives; the rest is for attention.
    pub lift_share: f64,
}

impl Default for MoveToTarget {
    fn default() -> Self {
        Self { steps: 140, goal_distance: 0.06, goal_share: 0.6, lift_share: 0.25 }
    }
}

/// The individuals of an earlier experiment from which generation 0 is made, in place of random ones.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Ancestors {
    /// Their genes, four hexadecimal digits each, one text an individual.
    #[serde(with = "genes")]
    pub genotypes: Vec<Genotype>,
    /// Whether their genes evolve as well. In the paper's second phase they stay as they are.
    pub evolve: bool,
}

mod genes {
    use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

    use crate::genotype::Genotype;

    pub(super) fn serialize<S: Serializer>(genotypes: &[Genotype], to: S) -> Result<S::Ok, S::Error> {
        genotypes.iter().map(Genotype::to_hex).collect::<Vec<_>>().serialize(to)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<Genotype>, D::Error> {
        let texts = Vec::<String>::deserialize(from)?;
        texts.iter().map(|text| Genotype::from_hex(text).map_err(de::Error::custom)).collect()
    }
}
