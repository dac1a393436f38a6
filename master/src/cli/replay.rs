//! `selftalk replay`: trials of a stored individual, run again, as a page that plays them or as data.

use std::fs;
use std::io::Write;
use std::path::Path;

use selftalk_sim::{Behaviour, Case, Simulator};

use super::args::{ReplayArgs, Which};
use super::individuals::{Individual, find, warn_foreign};
use super::show::differs;
use super::work::crew;
use super::{Global, picture, select};
use crate::exit::{Exit, Failure};
use crate::replay::{Recording, csv, mcap, page, strip};
use crate::retest::difference;

/// Carries out the command.
///
/// # Errors
/// [`Failure`] with the exit code and the line to print.
pub async fn run(args: ReplayArgs, global: &Global) -> Result<(), Failure> {
    let store = select::open(global).await?;
    let which = Which {
        individuals: vec![args.individual.clone()],
        of: args.of.clone(),
        generation: args.generation,
    };
    let individuals = find(&store, &which, crew(None, &|| {})).await?;
    warn_foreign(&individuals)?;
    let Some(individual) = individuals.first() else { return Ok(()) };
    let recordings = recordings(individual, &args)?;
    if let Some(path) = &args.json {
        let text =
            serde_json::to_string(&recordings).map_err(|error| Failure::new(Exit::Unexpected, error))?;
        return write(path, text.as_bytes());
    }
    if let Some(path) = &args.csv {
        let recording = one(&recordings, individual, "--csv")?;
        let mut text = Vec::new();
        csv(recording, &mut text).map_err(|error| Failure::new(Exit::Unexpected, error))?;
        return write(path, &text);
    }
    if let Some(path) = &args.strip {
        return picture::write(path, &strip(one(&recordings, individual, "--strip")?));
    }
    if let Some(path) = &args.mcap {
        let file = mcap(&recordings).map_err(|error| Failure::new(Exit::Unexpected, error))?;
        return write(path, &file);
    }
    let text = page(&recordings).map_err(|error| Failure::new(Exit::Unexpected, error))?;
    write(&args.html, text.as_bytes())?;
    eprintln!("{} plays it in any browser", args.html.display());
    Ok(())
}

/// The trials that are meant, which have to come to what is stored.
fn recordings(individual: &Individual, args: &ReplayArgs) -> Result<Vec<Recording>, Failure> {
    let simulator = Simulator::new(&individual.experiment)?;
    let trials = simulator.trial_count();
    if let Some(trial) = args.trial.filter(|trial| *trial >= trials) {
        return Err(select::missing("trial", trial, trials as usize));
    }
    let meant = |trial: &u32| {
        args.trial.is_none_or(|only| only == *trial)
            && args.behaviour.as_ref().is_none_or(|name| simulator.behaviour(*trial).name() == name)
    };
    let recordings: Vec<Recording> = (0..trials)
        .filter(meant)
        .map(|trial| recording(&simulator, individual, trial))
        .collect::<Result<_, _>>()?;
    if recordings.is_empty() {
        let names: Vec<&str> =
            simulator.behaviours().iter().map(|behaviour| Behaviour::name(*behaviour)).collect();
        let message = format!("there is no such trial; the behaviours are: {}", names.join(", "));
        return Err(Failure::new(Exit::Usage, message));
    }
    Ok(recordings)
}

/// The trial, if it is only one.
fn one<'a>(
    recordings: &'a [Recording],
    individual: &Individual,
    option: &str,
) -> Result<&'a Recording, Failure> {
    let [recording] = recordings else {
        let message = format!(
            "{option} takes one trial and these are {}; choose it with --trial, 0 to {}",
            recordings.len(),
            individual.evaluated.outcomes.len().saturating_sub(1)
        );
        return Err(Failure::new(Exit::Usage, message));
    };
    Ok(recording)
}

/// A trial, which has to come to what is stored.
pub(super) fn recording(
    simulator: &Simulator,
    individual: &Individual,
    trial: u32,
) -> Result<Recording, Failure> {
    let case = Case::Drawn { draw: individual.draw(), trial };
    let trace = simulator.trace(&individual.member.genotype, case)?;
    let stored = individual.evaluated.outcomes.get(trial as usize);
    if let Some(words) = stored.and_then(|stored| difference(stored, &trace.outcome)) {
        return Err(differs(individual, trial, &words)?);
    }
    let name = individual.name.to_string();
    let recording = Recording::new(name, trial, simulator.behaviour(trial), &trace);
    recording.map_err(|error| Failure::new(Exit::Unexpected, error))
}

/// Writes a file, or stdout for `-`.
fn write(path: &Path, content: &[u8]) -> Result<(), Failure> {
    let written =
        if path == Path::new("-") { std::io::stdout().write_all(content) } else { fs::write(path, content) };
    written.map_err(|error| {
        Failure::new(Exit::Unexpected, format!("{}: cannot be written: {error}", path.display()))
    })
}
