//! `selftalk transfer`: how good individuals are in a physics engine that is not theirs.

use selftalk_sim::experiment::Engine;

use super::args::TransferArgs;
use super::evaluate::{WHO, evaluated, shares_of, who};
use super::individuals::{Individual, find, warn_foreign};
use super::output::Table;
use super::work::crew;
use super::{Global, select};
use crate::exit::{Exit, Failure};

/// What the trials in the other engine came to.
const SHARES: [&str; 12] = [
    "engine", "reach", "open", "grasp", "move", "all", "to", "to_reach", "to_open", "to_grasp", "to_move",
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
        let to = other(experiment.engine, to)?;
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

/// The engine that was asked for, or the first that is not the experiment's.
fn other(own: Engine, asked: Option<Engine>) -> Result<Engine, Failure> {
    let other = asked.or_else(|| Engine::ALL.iter().copied().find(|engine| *engine != own));
    let none = || format!("there is no engine beside {}; `--to` can name it nonetheless", own.name());
    other.ok_or_else(|| Failure::new(Exit::Usage, none()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_engine_is_meant_unless_one_is_named() {
        for own in Engine::ALL.iter().copied() {
            assert_eq!(other(own, Some(own)), Ok(own));
            match other(own, None) {
                Ok(found) => assert_ne!(found, own),
                Err(failure) => assert_eq!((failure.exit, Engine::ALL.len()), (Exit::Usage, 1)),
            }
        }
    }
}
