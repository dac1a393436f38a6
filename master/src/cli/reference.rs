//! How individuals are named on the command line.

use std::fmt;

use crate::exit::{Exit, Failure};

/// The name of an individual: `EXPERIMENT/REPLICATION/GENERATION/INDIVIDUAL`, as `selftalk history individuals` lists
/// them. The names of experiments have no slash.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Name {
    /// The experiment.
    pub experiment: String,
    /// Replication, counted from 0.
    pub replication: u32,
    /// Generation, counted from 0.
    pub generation: u32,
    /// Its number in the generation, counted from 0.
    pub individual: u32,
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { experiment, replication, generation, individual } = self;
        write!(f, "{experiment}/{replication}/{generation}/{individual}")
    }
}

/// Which individuals are meant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Reference {
    /// The best individual of a generation of each replication.
    Best,
    /// The individual that stands for each replication; see [`crate::retest::champion`].
    Champion,
    /// One by its name.
    Named(Name),
}

impl Reference {
    /// Reads `best`, `champion` or a name.
    ///
    /// # Errors
    /// [`Exit::Usage`] when it is none of them.
    pub fn parse(text: &str) -> Result<Self, Failure> {
        match text {
            "best" => Ok(Self::Best),
            "champion" => Ok(Self::Champion),
            _ => name(text).map(Self::Named).ok_or_else(|| {
                let message = format!(
                    "`{text}` names no individual; expected `best`, `champion` or \
                     EXPERIMENT/REPLICATION/GENERATION/INDIVIDUAL, such as quickstart/0/59/12"
                );
                Failure::new(Exit::Usage, message)
            }),
        }
    }
}

fn name(text: &str) -> Option<Name> {
    let parts: Vec<&str> = text.split('/').collect();
    let [experiment, replication, generation, individual] = parts[..] else { return None };
    Some(Name {
        experiment: Some(experiment).filter(|name| !name.is_empty())?.to_owned(),
        replication: number(replication)?,
        generation: number(generation)?,
        individual: number(individual)?,
    })
}

/// Digits only: no sign.
fn number(text: &str) -> Option<u32> {
    text.bytes().all(|byte| byte.is_ascii_digit()).then(|| text.parse().ok())?
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_reads_back_as_it_is_written() {
        let name = Name { experiment: "a.b-1".to_owned(), replication: 3, generation: 1499, individual: 7 };
        assert_eq!(name.to_string(), "a.b-1/3/1499/7");
        assert_eq!(Reference::parse("a.b-1/3/1499/7"), Ok(Reference::Named(name)));
        assert_eq!(Reference::parse("best"), Ok(Reference::Best));
        assert_eq!(Reference::parse("champion"), Ok(Reference::Champion));
    }

    #[test]
    fn what_names_nothing_is_refused_with_an_example() {
        for text in
            ["", "7", "a/1/2", "a/1/2/3/4", "/1/2/3", "a/1/2/x", "a/1/2/-3", "a/1/2/+3", "a/1//3", "BEST"]
        {
            let failure = Reference::parse(text).unwrap_err();
            assert_eq!(failure.exit, Exit::Usage);
            assert!(failure.message.contains(&format!("`{text}` names no individual")), "{failure}");
            assert!(failure.message.contains("quickstart/0/59/12"), "{failure}");
        }
        assert!(Reference::parse("a/1/2/4294967296").is_err());
    }
}
