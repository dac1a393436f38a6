//! What touches what, and how contacts are resolved.

use rapier3d_f64::prelude::{
    Group, IntegrationParameters, InteractionGroups, InteractionTestMode, SpringCoefficients,
};

use crate::experiment::Physics;
use crate::physics::{CONTROL_STEP, CORRECTION_SPEED};

/// Solver iterations of a physics step. Each has a part of the step, with motion, servos and gaps computed anew.
const SOLVER_ITERATIONS: usize = 4;
/// A contact's spring, as frequency (Hz) and damping ratio of what it acts between: so stiff that what is held
/// overlaps by less than 0.1 mm, so damped that it does not swing.
const SOFTNESS: SpringCoefficients<f64> = SpringCoefficients { natural_frequency: 500.0, damping_ratio: 5.0 };

/// What a shape is. It decides which others it can touch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    /// The table.
    Table,
    /// The object where it is round.
    Ball,
    /// The object's flat base.
    Base,
    /// Palm, fingertips and forearm.
    Robot,
    /// A finger's first phalanx, which touches the object alone.
    Proximal,
}

impl Role {
    pub(super) fn groups(self) -> InteractionGroups {
        let (table, ball, base) = (Group::GROUP_1, Group::GROUP_2, Group::GROUP_3);
        let (robot, proximal) = (Group::GROUP_4, Group::GROUP_5);
        let (own, others) = match self {
            Self::Table => (table, ball | base | robot),
            Self::Ball => (ball, table | robot | proximal),
            Self::Base => (base, table),
            Self::Robot => (robot, table | ball),
            Self::Proximal => (proximal, ball),
        };
        InteractionGroups::new(own, others, InteractionTestMode::And)
    }
}

/// How a physics step resolves the contacts. Each solver iteration sweeps over them as often as the experiment says
/// (Gauss-Seidel), moves everything, and sweeps as often again without what undoes overlaps, which so leaves no speed
/// behind.
pub(super) fn parameters(physics: &Physics) -> IntegrationParameters {
    let sweeps = usize::try_from(physics.sweeps).unwrap_or(usize::MAX);
    IntegrationParameters {
        dt: CONTROL_STEP / f64::from(physics.substeps),
        num_solver_iterations: SOLVER_ITERATIONS,
        num_internal_pgs_iterations: sweeps,
        num_internal_stabilization_iterations: sweeps,
        contact_softness: SOFTNESS,
        static_contact_softness: SOFTNESS,
        normalized_max_corrective_velocity: CORRECTION_SPEED,
        // Nothing slides while an overlap is undone.
        friction_in_bias_pass: true,
        // Contacts are found anew in every step, each pair's by themselves.
        contact_recycling: false,
        contact_clustering: false,
        // The table has no other side, and the object is thicker than the hand's way in a step.
        max_ccd_substeps: 0,
        ..IntegrationParameters::default()
    }
}
