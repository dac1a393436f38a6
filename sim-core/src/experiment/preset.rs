//! Experiments that are shipped with the simulator.

use super::{Experiment, ExperimentError};

/// A shipped experiment.
#[derive(Debug, Clone, Copy)]
pub struct Preset {
    /// Name on the command line, and of the experiment.
    pub name: &'static str,
    /// The experiment file.
    pub toml: &'static str,
}

/// All presets, in the order in which people come to them.
pub const PRESETS: &[Preset] = &[
    Preset { name: "quickstart", toml: include_str!("../../presets/quickstart.toml") },
    Preset { name: "elementary", toml: include_str!("../../presets/elementary.toml") },
    Preset { name: "elementary-0.5", toml: include_str!("../../presets/elementary-0.5.toml") },
    Preset { name: "elementary-linked", toml: include_str!("../../presets/elementary-linked.toml") },
    Preset { name: "elementary-further", toml: include_str!("../../presets/elementary-further.toml") },
    Preset { name: "elementary-refined", toml: include_str!("../../presets/elementary-refined.toml") },
    Preset { name: "integrated-c", toml: include_str!("../../presets/integrated-c.toml") },
    Preset { name: "integrated-le", toml: include_str!("../../presets/integrated-le.toml") },
    Preset { name: "integrated-st", toml: include_str!("../../presets/integrated-st.toml") },
    Preset { name: "integrated-lst", toml: include_str!("../../presets/integrated-lst.toml") },
    Preset { name: "linked-c", toml: include_str!("../../presets/linked-c.toml") },
    Preset { name: "linked-le", toml: include_str!("../../presets/linked-le.toml") },
    Preset { name: "linked-st", toml: include_str!("../../presets/linked-st.toml") },
    Preset { name: "linked-lst", toml: include_str!("../../presets/linked-lst.toml") },
];

impl Preset {
    /// The preset of that name.
    #[must_use]
    pub fn find(name: &str) -> Option<&'static Self> {
        PRESETS.iter().find(|preset| preset.name == name)
    }

    /// The preset with `key=value` overrides applied.
    ///
    /// # Errors
    /// [`ExperimentError`] when an override does not fit.
    pub fn experiment(&self, overrides: &[String]) -> Result<Experiment, ExperimentError> {
        Experiment::from_toml(self.name, self.toml, overrides)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_is_valid_and_carries_its_name() {
        for preset in PRESETS {
            let experiment = preset.experiment(&[]).unwrap();
            assert_eq!(experiment.name, preset.name);
        }
    }

    #[test]
    fn what_elementary_linked_has_begun_goes_on_alike() {
        let [linked, further, refined] = ["elementary-linked", "elementary-further", "elementary-refined"]
            .map(|name| Preset::find(name).unwrap().experiment(&[]).unwrap());
        for mut later in [further, refined] {
            assert!(later.ancestors.evolve);
            later.ancestors.evolve = false;
            later.name.clone_from(&linked.name);
            later.evolution.mutation = linked.evolution.mutation;
            assert_eq!(later, linked);
        }
    }

    #[test]
    fn the_linked_conditions_are_the_paper_s_with_other_settings() {
        for condition in ["c", "le", "st", "lst"] {
            let [paper, mut linked] = ["integrated", "linked"].map(|second| {
                Preset::find(&format!("{second}-{condition}")).unwrap().experiment(&[]).unwrap()
            });
            assert_eq!((linked.evolution.mutation, linked.move_to_target.steps), (0.04, 200));
            linked.name.clone_from(&paper.name);
            linked.evolution.mutation = paper.evolution.mutation;
            linked.physics.substeps = paper.physics.substeps;
            linked.move_to_target.steps = paper.move_to_target.steps;
            linked.caretaker.anticipation_share = paper.caretaker.anticipation_share;
            assert_eq!(linked, paper);
        }
    }

    #[test]
    fn elementary_is_the_default_experiment() {
        let preset = Preset::find("elementary").unwrap();
        assert_eq!(preset.experiment(&[]), Ok(Experiment::default()));
    }
}
