//! `selftalk show --weights`: the numbers of an individual's controller.

use std::path::Path;

use selftalk_sim::controller::{Network, Parameter, Role};

use super::individuals::Individual;
use super::output::{Cell, Table, print_tables};
use super::picture;
use super::{Format, Global};
use crate::exit::{Exit, Failure};
use crate::weights::{Block, blocks, diagram, kind, neuron};

/// Prints the numbers of controllers: for people as tables, for programs a line a number.
pub(super) fn print(individuals: &[Individual], global: &Global) -> Result<(), Failure> {
    if global.format != Format::Table {
        return list(individuals)?.print(global.format);
    }
    let mut tables = Vec::new();
    for individual in individuals {
        tables.extend(blocks(&parameters(individual)?).iter().map(table));
    }
    print_tables(&tables)
}

/// Draws a controller into a file.
pub(super) fn draw(individuals: &[Individual], path: &Path) -> Result<(), Failure> {
    let [individual] = individuals else {
        let message = format!(
            "--image draws one individual and these are {}; name one, such as {}",
            individuals.len(),
            individuals.first().map_or(String::new(), |individual| individual.name.to_string())
        );
        return Err(Failure::new(Exit::Usage, message));
    };
    picture::write(path, &diagram(&individual.name.to_string(), &parameters(individual)?))?;
    eprintln!("{} has the weights of {}", path.display(), individual.name);
    Ok(())
}

fn parameters(individual: &Individual) -> Result<Vec<Parameter>, Failure> {
    let network = Network::new(&individual.member.genotype, &individual.experiment.controller);
    network.map(|network| network.parameters()).map_err(|error| Failure::new(Exit::Database, error))
}

/// A line a number.
fn list(individuals: &[Individual]) -> Result<Table, Failure> {
    let mut table = Table::new([
        "experiment",
        "replication",
        "generation",
        "individual",
        "parameter",
        "from_kind",
        "from",
        "to_kind",
        "to",
        "value",
    ]);
    for individual in individuals {
        let name = &individual.name;
        for Parameter { neuron: to, role, value } in parameters(individual)? {
            let (parameter, from) = match role {
                Role::From(from) => ("weight", Some(from)),
                Role::Bias => ("bias", None),
                Role::Kept => ("time_constant", None),
            };
            table.push([
                name.experiment.as_str().into(),
                name.replication.into(),
                name.generation.into(),
                name.individual.into(),
                parameter.into(),
                from.map(kind).into(),
                from.map(neuron).into(),
                kind(to).into(),
                neuron(to).into(),
                value.into(),
            ]);
        }
    }
    Ok(table)
}

/// A table for people, with columns by their numbers where their names would be too long.
fn table(block: &Block) -> Table {
    let short = |name: &String| name.rsplit_once('_').map_or(name.clone(), |(_, number)| number.to_owned());
    let columns = std::iter::once(block.title.to_owned()).chain(block.columns.iter().map(short));
    let mut table = Table::new(columns.collect::<Vec<_>>());
    for (name, values) in block.rows.iter().zip(&block.values) {
        let value = |value: &Option<f64>| value.map_or(Cell::Empty, |value| format!("{value:5.2}").into());
        table.push(std::iter::once(name.as_str().into()).chain(values.iter().map(value)).collect::<Vec<_>>());
    }
    table
}
