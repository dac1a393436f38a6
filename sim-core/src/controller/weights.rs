//! A network's numbers, one by one, for those who want to look at them.

use super::{ADDED, INTERNAL, MOTORS, Network, SENSORS};

/// A neuron, by its number within its kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Neuron {
    /// A sensory neuron.
    Sensor(usize),
    /// The input that says whether MOVE-TO-TARGET is asked for.
    Task,
    /// An internal neuron.
    Internal(usize),
    /// A neuron that the second phase adds.
    Added(usize),
    /// A motor neuron.
    Motor(usize),
}

/// What a number of a network is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Role {
    /// The weight of the connection from a neuron.
    From(Neuron),
    /// The bias.
    Bias,
    /// The time constant: the share of its activity that a neuron keeps in a step.
    Kept,
}

/// A number of a network: what it is, and of which neuron.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// The neuron it belongs to; of a connection, the one that is reached.
    pub neuron: Neuron,
    /// What it is for that neuron.
    pub role: Role,
    /// The number.
    pub value: f64,
}

impl Network {
    /// All numbers of the network, neuron by neuron: the internal ones, the added ones, the motor ones; each with its
    /// weights in the order of [`Neuron`], its bias, and its time constant if it has one.
    #[must_use]
    pub fn parameters(&self) -> Vec<Parameter> {
        let mut all = Vec::new();
        for at in 0..INTERNAL {
            let mut add = |role, value| all.push(Parameter { neuron: Neuron::Internal(at), role, value });
            for from in 0..SENSORS {
                add(Role::From(Neuron::Sensor(from)), self.sensory[from][at]);
            }
            if let Some(recurrent) = self.recurrent.as_deref() {
                for (from, row) in recurrent.iter().enumerate() {
                    add(Role::From(Neuron::Internal(from)), row[at]);
                }
            }
            if let Some(extension) = self.extension.as_deref() {
                for from in 0..ADDED {
                    add(Role::From(Neuron::Added(from)), extension.back[from][at]);
                }
            }
            add(Role::Bias, self.internal_bias[at]);
            add(Role::Kept, self.kept[at]);
        }
        if let Some(extension) = self.extension.as_deref() {
            for at in 0..ADDED {
                let mut add = |role, value| all.push(Parameter { neuron: Neuron::Added(at), role, value });
                add(Role::From(Neuron::Task), extension.task[at]);
                for from in 0..INTERNAL {
                    add(Role::From(Neuron::Internal(from)), extension.internal[from][at]);
                }
                for from in 0..ADDED {
                    add(Role::From(Neuron::Added(from)), extension.own[from][at]);
                }
                add(Role::Bias, extension.bias[at]);
                add(Role::Kept, extension.kept[at]);
            }
        }
        for at in 0..MOTORS {
            let mut add = |role, value| all.push(Parameter { neuron: Neuron::Motor(at), role, value });
            for from in 0..INTERNAL {
                add(Role::From(Neuron::Internal(from)), self.motor[from][at]);
            }
            add(Role::Bias, self.motor_bias[at]);
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::super::Layout;
    use super::*;
    use crate::experiment::{Added, Controller};
    use crate::genotype::Genotype;

    #[test]
    fn every_gene_is_a_parameter_once() {
        for (recurrent, added) in [(false, Added::None), (true, Added::Speech)] {
            let settings = Controller { recurrent, added, ..Controller::default() };
            let genes = Layout::new(&settings).genes();
            let genotype = Genotype::new((0..genes).map(|gene| 7 + gene as u16).collect::<Vec<_>>());
            let parameters = Network::new(&genotype, &settings).unwrap().parameters();
            let gene = |parameter: &Parameter| {
                let unit = match parameter.role {
                    Role::Kept => parameter.value,
                    _ => (parameter.value / settings.weight_range + 1.0) / 2.0,
                };
                (unit * f64::from(u16::MAX)).round() as usize - 7
            };
            let mut found: Vec<usize> = parameters.iter().map(gene).collect();
            found.sort_unstable();
            assert_eq!(found, (0..genes).collect::<Vec<_>>());
            let mut named: Vec<_> =
                parameters.iter().map(|parameter| (parameter.neuron, parameter.role)).collect();
            named.sort_unstable();
            named.dedup();
            assert_eq!(named.len(), genes);
        }
    }

    #[test]
    fn a_weight_is_that_of_its_connection() {
        let settings = Controller::default();
        // The second internal neuron's weight from the fourth sensor, as the layout has it.
        let place = (SENSORS + 2) + 3;
        let mut genes = vec![0; Layout::new(&settings).genes()];
        genes[place] = u16::MAX;
        let parameters = Network::new(&Genotype::new(genes), &settings).unwrap().parameters();
        let positive: Vec<_> = parameters.iter().filter(|parameter| parameter.value > 0.0).collect();
        assert_eq!(positive.len(), 1);
        assert_eq!(
            (positive[0].neuron, positive[0].role),
            (Neuron::Internal(1), Role::From(Neuron::Sensor(3)))
        );
    }
}
