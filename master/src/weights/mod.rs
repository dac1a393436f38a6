//! A controller's numbers by the names of its neurons: as a list, as tables and as a diagram.

mod diagram;

use selftalk_sim::controller::{Neuron, Parameter, Role};

use crate::replay::{MOTORS, SENSORS};

pub use diagram::diagram;

/// A table of numbers: a row for what the numbers are, a column for each neuron they belong to; of the motor neurons, which
/// have the longest names, the other way round.
#[derive(Debug, Clone, PartialEq)]
pub struct Block {
    /// What it is a table of.
    pub title: &'static str,
    /// Names of the rows.
    pub rows: Vec<String>,
    /// Names of the columns.
    pub columns: Vec<String>,
    /// The numbers, row by row; none where there is no such connection.
    pub values: Vec<Vec<Option<f64>>>,
}

/// A neuron's name.
#[must_use]
pub fn neuron(neuron: Neuron) -> String {
    let named =
        |names: &[&str], at: usize| names.get(at).map_or_else(|| at.to_string(), |name| (*name).to_owned());
    match neuron {
        Neuron::Sensor(at) => named(&SENSORS, at),
        Neuron::Task => "move-to-target".to_owned(),
        Neuron::Internal(at) => format!("internal_{at}"),
        Neuron::Added(at) => format!("added_{at}"),
        Neuron::Motor(at) => named(&MOTORS, at),
    }
}

/// The kind of a neuron.
#[must_use]
pub const fn kind(neuron: Neuron) -> &'static str {
    match neuron {
        Neuron::Sensor(_) => "sensor",
        Neuron::Task => "task",
        Neuron::Internal(_) => "internal",
        Neuron::Added(_) => "added",
        Neuron::Motor(_) => "motor",
    }
}

/// What a number is: the name of the neuron a connection comes from, `bias` or `time constant`.
#[must_use]
pub fn role(role: Role) -> String {
    match role {
        Role::From(from) => neuron(from),
        Role::Bias => "bias".to_owned(),
        Role::Kept => "time constant".to_owned(),
    }
}

/// The numbers as tables, one for each kind of neurons.
#[must_use]
pub fn blocks(parameters: &[Parameter]) -> Vec<Block> {
    let kinds = [
        ("to the internal neurons", "internal", false),
        ("to the added neurons", "added", false),
        ("to the motor neurons", "motor", true),
    ];
    let block = |(title, wanted, turned): (&'static str, &str, bool)| {
        let of: Vec<&Parameter> =
            parameters.iter().filter(|parameter| kind(parameter.neuron) == wanted).collect();
        let (mut neurons, mut roles) = (Vec::new(), Vec::new());
        for parameter in &of {
            if !neurons.contains(&parameter.neuron) {
                neurons.push(parameter.neuron);
            }
            if !roles.contains(&parameter.role) {
                roles.push(parameter.role);
            }
        }
        let value = |neuron: Neuron, role: Role| {
            let found = of.iter().find(|parameter| (parameter.neuron, parameter.role) == (neuron, role));
            found.map(|parameter| parameter.value)
        };
        let neuron_names: Vec<String> = neurons.iter().map(|of| neuron(*of)).collect();
        let role_names: Vec<String> = roles.iter().map(|of| role(*of)).collect();
        if turned {
            let row = |of: &Neuron| roles.iter().map(|role| value(*of, *role)).collect();
            Block {
                title,
                rows: neuron_names,
                columns: role_names,
                values: neurons.iter().map(row).collect(),
            }
        } else {
            let row = |of: &Role| neurons.iter().map(|neuron| value(*neuron, *of)).collect();
            Block { title, rows: role_names, columns: neuron_names, values: roles.iter().map(row).collect() }
        }
    };
    kinds.into_iter().map(block).filter(|block| !block.rows.is_empty()).collect()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use selftalk_sim::Genotype;
    use selftalk_sim::controller::{Layout, Network};
    use selftalk_sim::experiment::{Added, Controller};

    pub(crate) fn parameters(added: Added) -> Vec<Parameter> {
        let settings = Controller { added, ..Controller::default() };
        let genes: Vec<u16> =
            (0..Layout::new(&settings).genes() as u32).map(|gene| (gene * 97) as u16).collect();
        Network::new(&Genotype::new(genes), &settings).unwrap().parameters()
    }

    #[test]
    fn tables_have_every_number_once() {
        let parameters = parameters(Added::Speech);
        let blocks = blocks(&parameters);
        let shapes: Vec<(usize, usize)> =
            blocks.iter().map(|block| (block.rows.len(), block.columns.len())).collect();
        assert_eq!(shapes, [(25 + 4 + 2, 15), (1 + 15 + 4 + 2, 4), (13, 15 + 1)]);
        let count: usize = blocks.iter().flat_map(|block| &block.values).flatten().flatten().count();
        assert_eq!(count, parameters.len());
        assert_eq!(blocks[2].rows[0], "focus");
        assert_eq!(blocks[0].rows[24], "label_move");
    }

    #[test]
    fn without_added_neurons_there_is_no_table_of_them() {
        let titles: Vec<&str> = blocks(&parameters(Added::None)).iter().map(|block| block.title).collect();
        assert_eq!(titles, ["to the internal neurons", "to the motor neurons"]);
    }
}
