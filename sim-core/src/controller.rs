//! The neural controller (paper, sections II.B and III): 25 sensors, 15 leaky integrators, 13 motors, fully connected
//! from layer to layer; in the second phase four more leaky integrators, connected with the 15 both ways and among
//! themselves, which also feel whether MOVE-TO-TARGET is asked for.

mod weights;

use crate::experiment::{self, Added, Experiment};
use crate::genotype::{Genotype, GenotypeError};

pub use weights::{Neuron, Parameter, Role};

/// Sensory neurons.
pub const SENSORS: usize = 25;
/// Internal neurons: leaky integrators.
pub const INTERNAL: usize = 15;
/// Motor neurons.
pub const MOTORS: usize = 13;
/// Neurons that the second phase adds: leaky integrators.
pub const ADDED: usize = 4;

/// How the genes are laid out: for each internal neuron its weights from the sensors, with recurrence its weights
/// from the internal neurons, its bias and its time constant; then for each motor neuron its weights from the
/// internal neurons and its bias. After these, with added neurons: for each of them its weights from the internal
/// neurons, from the added ones and from the input for MOVE-TO-TARGET, its bias and its time constant; then for each
/// internal neuron its weights from the added ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout {
    recurrent: bool,
    added: Added,
}

impl Layout {
    /// The layout of an experiment's controllers.
    #[must_use]
    pub fn new(settings: &experiment::Controller) -> Self {
        Self { recurrent: settings.recurrent, added: settings.added }
    }

    /// Number of genes.
    #[must_use]
    pub fn genes(self) -> usize {
        let added =
            if self.added == Added::None { 0 } else { ADDED * (INTERNAL + ADDED + 3) + INTERNAL * ADDED };
        self.elementary() + added
    }

    /// Number of genes without those of the added neurons, which come after them.
    #[must_use]
    pub fn elementary(self) -> usize {
        let recurrence = if self.recurrent { INTERNAL } else { 0 };
        INTERNAL * (SENSORS + recurrence + 2) + MOTORS * (INTERNAL + 1)
    }

    /// Number of genes that stay as an experiment's ancestors had them: all but those of the added neurons (paper, section
    /// III.B), or none where there are no ancestors or their genes evolve as well.
    #[must_use]
    pub fn inherited(experiment: &Experiment) -> usize {
        if experiment.ancestors.genotypes.is_empty() || experiment.ancestors.evolve {
            0
        } else {
            Self::new(&experiment.controller).elementary()
        }
    }
}

/// Activity of the motor neurons, in [0, 1].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motors(pub [f64; MOTORS]);

impl Motors {
    /// Analog output of the focus neuron.
    #[must_use]
    pub fn focus(&self) -> f64 {
        self.0[0]
    }

    /// Whether attention is on the target (focus above 0.5) and not on the object.
    #[must_use]
    pub fn attends_target(&self) -> bool {
        self.focus() > 0.5
    }
}

/// Activity of the leaky integrators, in [0, 1]; 0 at the start of a trial.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Activity {
    /// Of the internal neurons.
    pub internal: [f64; INTERNAL],
    /// Of the added neurons; 0 where there are none.
    pub added: [f64; ADDED],
}

impl Activity {
    /// The most active of the added neurons, the first of equals.
    #[must_use]
    pub fn most_active(&self) -> usize {
        (0..ADDED).rev().max_by(|a, b| self.added[*a].total_cmp(&self.added[*b])).unwrap_or_default()
    }
}

/// A controller's weights, ready to run: matrices by input, so that a neuron's sum runs over contiguous outputs.
#[derive(Debug, Clone, PartialEq)]
pub struct Network {
    sensory: [[f64; INTERNAL]; SENSORS],
    recurrent: Option<Box<[[f64; INTERNAL]; INTERNAL]>>,
    internal_bias: [f64; INTERNAL],
    /// Time constants: the share of its activity that an internal neuron keeps in a step.
    kept: [f64; INTERNAL],
    motor: [[f64; MOTORS]; INTERNAL],
    motor_bias: [f64; MOTORS],
    extension: Option<Box<Extension>>,
    slope: f64,
}

/// The weights of the added neurons.
#[derive(Debug, Clone, PartialEq)]
struct Extension {
    internal: [[f64; ADDED]; INTERNAL],
    own: [[f64; ADDED]; ADDED],
    task: [f64; ADDED],
    bias: [f64; ADDED],
    kept: [f64; ADDED],
    /// To the internal neurons.
    back: [[f64; INTERNAL]; ADDED],
}

/// The parameters in a genotype, one gene after the other.
struct Parameters<'a> {
    genes: std::slice::Iter<'a, u16>,
    weight_range: f64,
}

impl Parameters<'_> {
    /// The next gene in [0, 1]. The layout was checked: there is one.
    fn unit(&mut self) -> f64 {
        self.genes.next().map_or(0.0, |gene| f64::from(*gene) / f64::from(u16::MAX))
    }

    fn weight(&mut self) -> f64 {
        (2.0 * self.unit() - 1.0) * self.weight_range
    }

    /// A neuron's weights from some inputs.
    fn weights<const OUT: usize>(&mut self, rows: &mut [[f64; OUT]], neuron: usize) {
        for row in rows {
            row[neuron] = self.weight();
        }
    }
}

impl Network {
    /// Translates a genotype: a gene's 16 bits as a number, linear onto [-weight_range, weight_range] for weights
    /// and biases and onto [0, 1] for time constants.
    ///
    /// # Errors
    /// [`GenotypeError::Length`] when the genotype does not fit the layout.
    pub fn new(genotype: &Genotype, settings: &experiment::Controller) -> Result<Self, GenotypeError> {
        let layout = Layout::new(settings);
        let genes = genotype.genes();
        if genes.len() != layout.genes() {
            return Err(GenotypeError::Length { expected: layout.genes(), found: 2 * genes.len() });
        }
        let mut parameters = Parameters { genes: genes.iter(), weight_range: settings.weight_range };

        let mut network = Self {
            sensory: [[0.0; INTERNAL]; SENSORS],
            recurrent: layout.recurrent.then(|| Box::new([[0.0; INTERNAL]; INTERNAL])),
            internal_bias: [0.0; INTERNAL],
            kept: [0.0; INTERNAL],
            motor: [[0.0; MOTORS]; INTERNAL],
            motor_bias: [0.0; MOTORS],
            extension: None,
            slope: settings.slope,
        };
        for neuron in 0..INTERNAL {
            parameters.weights(&mut network.sensory, neuron);
            if let Some(recurrent) = network.recurrent.as_deref_mut() {
                parameters.weights(recurrent, neuron);
            }
            network.internal_bias[neuron] = parameters.weight();
            network.kept[neuron] = parameters.unit();
        }
        for neuron in 0..MOTORS {
            parameters.weights(&mut network.motor, neuron);
            network.motor_bias[neuron] = parameters.weight();
        }
        network.extension = (layout.added != Added::None).then(|| Box::new(Extension::new(&mut parameters)));
        Ok(network)
    }

    /// One control step: y <- k y + (1 - k) s(net) for the leaky integrators with time constants k, then s(net) for
    /// the motors; s is the logistic function. The internal neurons get the added ones' activity of the step before,
    /// these get the internal ones' of this step. `task` is the input for MOVE-TO-TARGET.
    pub fn step(&self, sensors: &[f64; SENSORS], task: f64, activity: &mut Activity) -> Motors {
        let Activity { internal, added } = activity;
        let mut net = self.internal_bias;
        accumulate(&mut net, &self.sensory, sensors);
        if let Some(recurrent) = &self.recurrent {
            accumulate(&mut net, recurrent, internal);
        }
        if let Some(extension) = &self.extension {
            accumulate(&mut net, &extension.back, added);
        }
        self.leak(internal, &net, &self.kept);
        if let Some(extension) = &self.extension {
            let mut net = extension.bias;
            accumulate(&mut net, &extension.internal, internal);
            accumulate(&mut net, &extension.own, added);
            accumulate(&mut net, &[extension.task], &[task]);
            self.leak(added, &net, &extension.kept);
        }
        let mut net = self.motor_bias;
        accumulate(&mut net, &self.motor, internal);
        Motors(net.map(|net| self.logistic(net)))
    }

    fn leak<const N: usize>(&self, activity: &mut [f64; N], net: &[f64; N], kept: &[f64; N]) {
        for ((y, net), kept) in activity.iter_mut().zip(net).zip(kept) {
            *y = kept * *y + (1.0 - kept) * self.logistic(*net);
        }
    }

    fn logistic(&self, net: f64) -> f64 {
        1.0 / (1.0 + libm::exp(-self.slope * net))
    }
}

impl Extension {
    fn new(parameters: &mut Parameters<'_>) -> Self {
        let mut extension = Self {
            internal: [[0.0; ADDED]; INTERNAL],
            own: [[0.0; ADDED]; ADDED],
            task: [0.0; ADDED],
            bias: [0.0; ADDED],
            kept: [0.0; ADDED],
            back: [[0.0; INTERNAL]; ADDED],
        };
        for neuron in 0..ADDED {
            parameters.weights(&mut extension.internal, neuron);
            parameters.weights(&mut extension.own, neuron);
            extension.task[neuron] = parameters.weight();
            extension.bias[neuron] = parameters.weight();
            extension.kept[neuron] = parameters.unit();
        }
        for neuron in 0..INTERNAL {
            parameters.weights(&mut extension.back, neuron);
        }
        extension
    }
}

fn accumulate<const IN: usize, const OUT: usize>(
    net: &mut [f64; OUT],
    weights: &[[f64; OUT]; IN],
    inputs: &[f64; IN],
) {
    for (row, input) in weights.iter().zip(inputs) {
        for (sum, weight) in net.iter_mut().zip(row) {
            *sum += weight * input;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(recurrent: bool) -> experiment::Controller {
        experiment::Controller { recurrent, ..experiment::Controller::default() }
    }

    #[test]
    fn the_paper_s_network_has_613_genes() {
        assert_eq!(Layout::new(&settings(false)).genes(), 613);
        assert_eq!(Layout::new(&settings(true)).genes(), 613 + 225);
    }

    #[test]
    fn genes_lie_where_the_layout_says() {
        let mut genes = [0x8000_u16; 613];
        genes[27 + 3] = u16::MAX; // internal neuron 1, sensor 3
        genes[27 + 25] = 0; // its bias
        genes[27 + 26] = u16::MAX; // its time constant
        genes[15 * 27 + 16 + 2] = u16::MAX; // motor 1, internal neuron 2
        genes[15 * 27 + 16 + 15] = 0; // its bias
        let network = Network::new(&Genotype::new(genes), &settings(false)).unwrap();
        assert_eq!(network.sensory[3][1], 1.0);
        assert_eq!(network.internal_bias[1], -1.0);
        assert_eq!(network.kept[1], 1.0);
        assert_eq!(network.motor[2][1], 1.0);
        assert_eq!(network.motor_bias[1], -1.0);
    }

    #[test]
    fn internal_neurons_leak() {
        let mut genes = [0x8000_u16; 613];
        for neuron in 0..INTERNAL {
            genes[neuron * 27 + 25] = u16::MAX; // biases of 1
            genes[neuron * 27 + 26] = 0xC000; // time constants of 3/4
        }
        let network = Network::new(&Genotype::new(genes), &settings(false)).unwrap();
        let mut activity = Activity::default();
        network.step(&[0.0; SENSORS], 0.0, &mut activity);
        let expected = 0.25 / (1.0 + libm::exp(-settings(false).slope));
        assert!((activity.internal[0] - expected).abs() < 1e-4, "{activity:?} {expected}");
        for _ in 0..200 {
            network.step(&[0.0; SENSORS], 0.0, &mut activity);
        }
        assert!((activity.internal[0] - 4.0 * expected).abs() < 1e-4);
    }

    #[test]
    fn a_genotype_of_another_layout_is_refused() {
        let genotype = Genotype::new([0_u16; 613]);
        assert!(Network::new(&genotype, &settings(true)).is_err());
    }

    /// Settings and genes of a controller with added neurons whose weights are 0 but for the given genes after the
    /// elementary ones.
    fn extended(genes: &[(usize, u16)]) -> (experiment::Controller, Network) {
        let settings = experiment::Controller { added: Added::Speech, ..settings(false) };
        let mut all = vec![0x8000_u16; Layout::new(&settings).genes()];
        for (at, gene) in genes {
            all[613 + at] = *gene;
        }
        let network = Network::new(&Genotype::new(all), &settings).unwrap();
        (settings, network)
    }

    #[test]
    fn added_neurons_have_148_genes_after_the_others() {
        let (settings, _) = extended(&[]);
        assert_eq!(Layout::new(&settings).genes(), 613 + 148);
        assert_eq!(Layout::new(&settings).elementary(), 613);
        let (_, network) = extended(&[(22 + 15 + 3, u16::MAX), (22 + 19, 0), (88 + 4 * 5 + 2, u16::MAX)]);
        let extension = network.extension.unwrap();
        assert_eq!(extension.own[3][1], 1.0, "added neuron 1, from added neuron 3");
        assert_eq!(extension.task[1], -1.0);
        assert_eq!(extension.back[2][5], 1.0, "internal neuron 5, from added neuron 2");
    }

    #[test]
    fn added_neurons_feel_the_task_and_act_on_the_internal_ones_a_step_later() {
        // Added neuron 0 hears the task, keeps nothing, and excites internal neuron 7.
        let (_, network) = extended(&[(19, u16::MAX), (21, 0), (88 + 4 * 7, u16::MAX)]);
        let run = |task| {
            let mut activity = Activity::default();
            let steps = [0; 2].map(|_| {
                network.step(&[0.0; SENSORS], task, &mut activity);
                activity
            });
            steps.map(|activity| (activity.added[0], activity.internal[7]))
        };
        let ([(asked, first), (_, second)], [(idle, quiet), _]) = (run(1.0), run(0.0));
        assert!(asked > 0.9 && (idle - 0.5).abs() < 1e-3, "{asked} {idle}");
        assert_eq!(first, quiet);
        assert!(second > 2.0 * first, "{first} {second}");
    }

    #[test]
    fn the_first_of_equally_active_neurons_is_the_most_active() {
        let most = |added| Activity { added, ..Activity::default() }.most_active();
        assert_eq!([most([0.0; 4]), most([0.1, 0.5, 0.5, 0.2]), most([0.1, 0.2, 0.3, 0.4])], [0, 1, 3]);
    }

    #[test]
    fn added_neurons_without_weights_change_nothing() {
        let genes: Vec<u16> = (0..613_u32).map(|gene| (gene * 40_503 % 65_536) as u16).collect();
        let plain = Network::new(&Genotype::new(genes.clone()), &settings(false)).unwrap();
        let (settings, _) = extended(&[]);
        let all: Vec<u16> = genes.into_iter().chain([0x8000; 148]).collect();
        let mut network = Network::new(&Genotype::new(all), &settings).unwrap();
        if let Some(extension) = network.extension.as_deref_mut() {
            // 0x8000 is half a step above a weight of 0.
            extension.back = [[0.0; INTERNAL]; ADDED];
        }
        let sensors = std::array::from_fn(|i| i as f64 / 10.0);
        let (mut one, mut other) = (Activity::default(), Activity::default());
        for _ in 0..5 {
            assert_eq!(plain.step(&sensors, 0.0, &mut one), network.step(&sensors, 1.0, &mut other));
        }
        assert_eq!(one.internal, other.internal);
    }
}
