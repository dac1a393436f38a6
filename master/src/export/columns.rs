//! What the tables have in their columns.

use std::borrow::Cow;

use super::{ExportError, signals};

/// What kind of values a column has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Words.
    Text,
    /// Whole numbers.
    Integer,
    /// Measured numbers, in double precision.
    Real,
    /// Whether something is so.
    Truth,
}

/// A column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Its name.
    pub name: Cow<'static, str>,
    /// What its values are.
    pub kind: Kind,
    /// Whether there may be none.
    pub optional: bool,
}

/// A value in a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value<'a> {
    /// There is none.
    Null,
    /// Words.
    Text(&'a str),
    /// A whole number.
    Integer(i64),
    /// A measured number.
    Real(f64),
    /// Whether something is so.
    Truth(bool),
}

impl<'a> From<&'a str> for Value<'a> {
    fn from(text: &'a str) -> Self {
        Self::Text(text)
    }
}

impl From<i64> for Value<'_> {
    fn from(value: i64) -> Self {
        Self::Integer(value)
    }
}

impl From<u32> for Value<'_> {
    fn from(value: u32) -> Self {
        Self::Integer(value.into())
    }
}

/// What is not a finite number is none: the database has it so, and not every reader of CSV knows NaN.
impl From<f64> for Value<'_> {
    fn from(value: f64) -> Self {
        if value.is_finite() { Self::Real(value) } else { Self::Null }
    }
}

impl From<bool> for Value<'_> {
    fn from(value: bool) -> Self {
        Self::Truth(value)
    }
}

impl<'a, T: Into<Value<'a>>> From<Option<T>> for Value<'a> {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Null, Into::into)
    }
}

/// A table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Topic {
    /// A row a generation.
    Generations,
    /// A row an individual.
    Individuals,
    /// A row a trial that was run by evolution.
    Trials,
    /// A row a control step of a trial that is run again.
    Signals,
}

const GENERATIONS: [Column; 12] = [
    always("experiment", Kind::Text),
    always("replication", Kind::Integer),
    always("generation", Kind::Integer),
    always("best_fitness", Kind::Real),
    always("mean_fitness", Kind::Real),
    always("best_individual", Kind::Integer),
    always("best_successes", Kind::Integer),
    always("most_successes", Kind::Integer),
    always("optimal_individuals", Kind::Integer),
    always("distinct_genotypes", Kind::Integer),
    always("wall_ms", Kind::Integer),
    always("committed_at", Kind::Text),
];

const INDIVIDUALS: [Column; 13] = [
    always("experiment", Kind::Text),
    always("replication", Kind::Integer),
    always("generation", Kind::Integer),
    always("individual", Kind::Integer),
    always("rank", Kind::Integer),
    always("fitness", Kind::Real),
    always("successes", Kind::Integer),
    always("origin", Kind::Text),
    perhaps("parent", Kind::Integer),
    always("flipped_bits", Kind::Integer),
    always("flipped", Kind::Text),
    always("evaluated_as", Kind::Integer),
    perhaps("failure", Kind::Text),
];

const TRIALS: [Column; 9] = [
    always("experiment", Kind::Text),
    always("replication", Kind::Integer),
    always("generation", Kind::Integer),
    always("individual", Kind::Integer),
    always("trial", Kind::Integer),
    always("behaviour", Kind::Text),
    perhaps("score", Kind::Real),
    always("success", Kind::Truth),
    always("steps", Kind::Integer),
];

const fn always(name: &'static str, kind: Kind) -> Column {
    Column { name: Cow::Borrowed(name), kind, optional: false }
}

const fn perhaps(name: &'static str, kind: Kind) -> Column {
    Column { name: Cow::Borrowed(name), kind, optional: true }
}

impl Topic {
    /// All tables.
    pub const ALL: [Self; 4] = [Self::Generations, Self::Individuals, Self::Trials, Self::Signals];

    /// Its name, which is also its file's.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Generations => "generations",
            Self::Individuals => "individuals",
            Self::Trials => "trials",
            Self::Signals => "signals",
        }
    }

    /// Its columns.
    ///
    /// # Errors
    /// [`ExportError::Robot`] when the shipped robot is damaged, whose joints some columns are named after.
    pub fn columns(self) -> Result<Vec<Column>, ExportError> {
        Ok(match self {
            Self::Generations => GENERATIONS.to_vec(),
            Self::Individuals => INDIVIDUALS.to_vec(),
            Self::Trials => TRIALS.to_vec(),
            Self::Signals => signals::columns()?,
        })
    }
}
