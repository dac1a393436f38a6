//! Many rows as one JSON array. Rows that SQLite's thread hands over one by one take several times as long as reading them
//! from the file.

use serde::Deserialize;
use serde::de::{DeserializeOwned, Deserializer, Error};

/// Units in 1. A real from 1/256 up to 8 is a whole number of them, to its last bit.
const UNITS: i64 = 1 << 60;

/// SQL for a real column that [`real`] reads back to the last bit, if it is 0 or between 1e-80 and 1e18: in units, where it is
/// a whole number of them, else in decimal. Decimals take SQLite twice as long as all the rest, and in its JSON
/// they have 15 digits only.
pub(super) fn column(name: &str) -> String {
    let units = format!("CAST({name} * {UNITS} AS INTEGER)");
    format!("CASE {name} * {UNITS} WHEN {units} THEN {units} ELSE printf('%!.20g', {name}) END")
}

/// Reads what [`column`] wrote.
pub(super) fn real<'de, D: Deserializer<'de>>(packed: D) -> Result<f64, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Packed<'a> {
        Units(i64),
        Digits(&'a str),
    }
    match Packed::deserialize(packed)? {
        // Both were doubles before, so nothing is rounded.
        Packed::Units(units) => Ok(units as f64 / UNITS as f64),
        Packed::Digits(digits) => digits.parse().map_err(D::Error::custom),
    }
}

/// The rows of a JSON array of arrays, each with a row's fields in their order.
pub(super) fn rows<T: DeserializeOwned>(packed: &str) -> Result<Vec<T>, sqlx::Error> {
    serde_json::from_str(packed).map_err(|error| sqlx::Error::Decode(error.into()))
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use proptest::prelude::*;
    use proptest::test_runner::{Config, TestRunner};
    use sqlx::{Connection, SqliteConnection};

    use super::*;

    #[derive(Debug, Clone, PartialEq, Deserialize)]
    struct Row {
        #[serde(deserialize_with = "real")]
        value: f64,
    }

    #[test]
    fn reals_come_back_to_the_last_bit() {
        let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
        let connection =
            RefCell::new(runtime.block_on(SqliteConnection::connect("sqlite::memory:")).unwrap());
        let statement = format!("SELECT json_array(json_array({}))", column("?1"));
        let packed = |value: f64| -> String {
            let query = sqlx::query_scalar(sqlx::AssertSqlSafe(statement.clone())).bind(value);
            runtime.block_on(query.fetch_one(&mut *connection.borrow_mut())).unwrap()
        };
        for value in [0.0, 1.0, 1.0 / 256.0, 8.0, -8.0] {
            assert_eq!(rows::<Row>(&packed(value)).unwrap(), [Row { value }]);
        }
        let scaled = (0.5..1.0, -264..60).prop_map(|(value, places)| libm::scalbn(value, places));
        let fitness = prop_oneof![0.0..=1.0, scaled];
        let mut runner = TestRunner::new(Config::with_cases(5000));
        let tested = runner.run(&fitness, |value| {
            let read = rows::<Row>(&packed(value)).unwrap();
            prop_assert_eq!(read[0].value.to_bits(), value.to_bits());
            Ok(())
        });
        tested.unwrap();
    }
}
