//! `selftalk transfer`: how good individuals are in a physics engine that is not theirs.

use super::args::TransferArgs;
use super::evaluate::{WHO, evaluated, shares_of, who};
use super::individuals::{Individual, find, warn_foreign};
use super::output::Table;
use super::work::crew;
use super::{Global, select};
use crate::exit::Failure;

/// What the trials in the other engine came to.
const SHARES: [&str; 14] = [
    "engine",
    "reach",
    "open",
    "grasp",
    "move",
    "move_to_target",
    "all",
    "to",
    "to_reach",
    "to_open",
    "to_grasp",
    "to_move",
    "to_move_to_target",
    "to_all",
];

/// Carries out the command.
///
/// # Errors
/// [`Failure`] with the exit code and the line to print.
pub async fn run(args: TransferArgs, global: &Global) -> Result<(), Failure> {
    let TransferArgs { which, fresh, to } = args;
    let store = select::open(global).await?;
    let individuals = find(&store, &which, crew(fresh.workers, &|| {})).await?;
    warn_foreign(&individuals)?;
    let mut table = Table::new(WHO.into_iter().chain(SHARES).collect::<Vec<_>>());
    for of_one in individuals.chunk_by(|a, b| a.experiment.engine == b.experiment.engine) {
        let Some(Individual { experiment, .. }) = of_one.first() else { continue };
        let to = to.unwrap_or(experiment.engine.other());
        let (here, there) = (evaluated(of_one, None, &fresh)?, evaluated(of_one, Some(to), &fresh)?);
        for (individual, (here, there)) in of_one.iter().zip(here.iter().zip(&there)) {
            let mut row = who(individual, here);
            row.push(experiment.engine.name().into());
            row.extend(shares_of(here));
            row.push(to.name().into());
            row.extend(shares_of(there));
            table.push(row);
        }
    }
    table.print(global.format)
}
