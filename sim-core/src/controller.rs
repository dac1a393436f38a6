//! The neural controller of the first training phase (paper, section II.B): 25 sensors, 15 leaky integrators, 13
//! motors, fully connected from layer to layer.

use crate::experiment;
use crate::genotype::{Genotype, GenotypeError};

/// Sensory neurons.
pub const SENSORS: usize = 25;
/// Internal neurons: leaky integrators.
pub const INTERNAL: usize = 15;
/// Motor neurons.
pub const MOTORS: usize = 13;

/// How the genes are laid out: for each internal neuron its weights from the sensors, with recurrence its weights
/// from the internal neurons, its bias and its time constant; then for each motor neuron its weights from the
/// internal neurons and its bias.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout {
    recurrent: bool,
}

impl Layout {
    /// The layout of an experiment's controllers.
    #[must_use]
    pub fn new(settings: &experiment::Controller) -> Self {
        Self { recurrent: settings.recurrent }
    }

    /// Number of genes.
    #[must_use]
    pub fn genes(self) -> usize {
        let recurrence = if self.recurrent { INTERNAL } else { 0 };
        INTERNAL * (SENSORS + recurrence + 2) + MOTORS * (INTERNAL + 1)
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
    slope: f64,
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
        let mut units = genes.iter().map(|gene| f64::from(*gene) / f64::from(u16::MAX));
        let mut unit = || units.next().unwrap_or_default();
        let range = settings.weight_range;
        let weight = |unit: f64| (2.0 * unit - 1.0) * range;

        let mut network = Self {
            sensory: [[0.0; INTERNAL]; SENSORS],
            recurrent: layout.recurrent.then(|| Box::new([[0.0; INTERNAL]; INTERNAL])),
            internal_bias: [0.0; INTERNAL],
            kept: [0.0; INTERNAL],
            motor: [[0.0; MOTORS]; INTERNAL],
            motor_bias: [0.0; MOTORS],
            slope: settings.slope,
        };
        for neuron in 0..INTERNAL {
            let recurrent = network.recurrent.as_deref_mut().map_or(&mut [][..], |rows| &mut rows[..]);
            for row in network.sensory.iter_mut().chain(recurrent) {
                row[neuron] = weight(unit());
            }
            network.internal_bias[neuron] = weight(unit());
            network.kept[neuron] = unit();
        }
        for neuron in 0..MOTORS {
            for row in &mut network.motor {
                row[neuron] = weight(unit());
            }
            network.motor_bias[neuron] = weight(unit());
        }
        Ok(network)
    }

    /// One control step: y <- k y + (1 - k) s(net) for the internal neurons with time constants k, then s(net) for
    /// the motors; s is the logistic function.
    pub fn step(&self, sensors: &[f64; SENSORS], internal: &mut [f64; INTERNAL]) -> Motors {
        let mut net = self.internal_bias;
        accumulate(&mut net, &self.sensory, sensors);
        if let Some(recurrent) = &self.recurrent {
            accumulate(&mut net, recurrent, internal);
        }
        for ((y, net), kept) in internal.iter_mut().zip(net).zip(self.kept) {
            *y = kept * *y + (1.0 - kept) * self.logistic(net);
        }
        let mut net = self.motor_bias;
        accumulate(&mut net, &self.motor, internal);
        Motors(net.map(|net| self.logistic(net)))
    }

    fn logistic(&self, net: f64) -> f64 {
        1.0 / (1.0 + libm::exp(-self.slope * net))
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
        let mut internal = [0.0; INTERNAL];
        network.step(&[0.0; SENSORS], &mut internal);
        let expected = 0.25 / (1.0 + libm::exp(-settings(false).slope));
        assert!((internal[0] - expected).abs() < 1e-4, "{} {expected}", internal[0]);
        for _ in 0..200 {
            network.step(&[0.0; SENSORS], &mut internal);
        }
        assert!((internal[0] - 4.0 * expected).abs() < 1e-4);
    }

    #[test]
    fn a_genotype_of_another_layout_is_refused() {
        let genotype = Genotype::new([0_u16; 613]);
        assert!(Network::new(&genotype, &settings(true)).is_err());
    }
}
