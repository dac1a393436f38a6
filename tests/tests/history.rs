//! What a finished history answers, in the formats that other programs read.

use std::collections::BTreeMap;

use selftalk_tests::Place;
use serde_json::Value;

const GENERATIONS: u64 = 5;

fn number(value: &Value) -> u64 {
    value.as_u64().unwrap_or_else(|| panic!("not a number: {value}"))
}

/// The bits of genes printed in hexadecimal.
fn bits(genes: &Value) -> Vec<bool> {
    let text = genes.as_str().unwrap();
    assert!(!text.is_empty() && text.len().is_multiple_of(4), "{text}");
    let gene = |at| u16::from_str_radix(&text[at..at + 4], 16).unwrap();
    let genes: Vec<u16> = (0..text.len()).step_by(4).map(gene).collect();
    genes.iter().flat_map(|gene| (0..16).map(move |bit| gene >> bit & 1 == 1)).collect()
}

/// Whether a field of CSV is this JSON value, whose parser may be one bit off.
fn same(field: &str, value: &Value) -> bool {
    match value {
        Value::Null => field.is_empty(),
        Value::String(text) => field == text,
        Value::Array(numbers) => field == numbers.iter().map(Value::to_string).collect::<Vec<_>>().join(" "),
        Value::Number(number) if number.is_f64() => {
            let (field, number) = (field.parse().unwrap_or(f64::NAN), number.as_f64().unwrap());
            (field - number).abs() <= f64::EPSILON * number.abs()
        }
        value => {
            let text = value.to_string();
            field == text
        }
    }
}

#[test]
fn json_and_csv_hold_the_same_records() {
    let place = Place::with_history(GENERATIONS);
    for (question, lines) in [
        ("history experiments", 1),
        ("history replications", 2),
        ("history generations", 2 * GENERATIONS),
        ("history individuals", 2 * 20),
        ("history lineage", 2 * GENERATIONS),
        ("history behaviours", 2 * GENERATIONS),
        ("history behaviours --bins 3", 2 * 3),
        ("history behaviours --curves", 2 * 4),
        ("digest", 2),
    ] {
        let objects = place.ask(question);
        assert_eq!(objects.len() as u64, lines, "{question}");
        let csv = place.run(&format!("{question} --format csv")).done().stdout;
        let mut csv = csv.lines();
        let header: Vec<&str> = csv.next().unwrap().split(',').collect();
        assert_eq!(csv.clone().count() as u64, lines, "{question}");
        for (record, object) in csv.zip(&objects) {
            let fields: Vec<&str> = record.split(',').collect();
            assert_eq!((fields.len(), header.len()), (header.len(), object.as_object().unwrap().len()));
            for (key, field) in header.iter().zip(fields) {
                let value = &object[*key];
                assert!(same(field, value), "{question}: {key}: {field:?} {value}");
            }
        }
        let table = place.run(question).done().stdout;
        assert_eq!(table.lines().count() as u64, lines + 1, "{table}");
    }
    assert!(!place.ask("history workers").is_empty());
}

#[test]
fn filters_select() {
    let place = Place::with_history(GENERATIONS);
    let all = place.ask("history generations");
    for (filter, keep) in [
        ("--experiment small", &(|_: &&Value| true) as &dyn Fn(&&Value) -> bool),
        ("--replication 1", &|line| line["replication"] == 1),
        ("--generation 3", &|line| line["generation"] == 3),
        ("--replication 0 --generation 0", &|line| line["replication"] == 0 && line["generation"] == 0),
    ] {
        let expected: Vec<Value> = all.iter().filter(keep).cloned().collect();
        assert_eq!(place.ask(&format!("history generations {filter}")), expected, "{filter}");
    }
    let best = place.ask("history individuals --best --generation 2");
    assert_eq!(best.len(), 2);
    for best in best {
        let generation =
            all.iter().find(|line| line["replication"] == best["replication"] && line["generation"] == 2);
        assert_eq!(best["fitness"], generation.unwrap()["best_fitness"]);
        assert_eq!(best["individual"], generation.unwrap()["best_individual"]);
    }
    for (question, word) in [
        ("history generations --experiment large", "there is: small"),
        ("history replications --replication 2", "from 0 to 1"),
        ("history individuals --generation 5", "from 0 to 4"),
        ("history lineage --individual 20", "from 0 to 19"),
        ("digest large", "there is: small"),
    ] {
        let message = place.run(question).refused(2);
        assert!(message.contains(word), "{message}");
    }
}

#[test]
fn every_genotype_of_every_generation_can_be_read_back() {
    let place = Place::with_history(GENERATIONS);
    let mut genotypes = BTreeMap::new();
    let mut varied = 0;
    for generation in 0..GENERATIONS {
        let individuals = place.ask(&format!("history individuals --genes --generation {generation}"));
        assert_eq!(individuals.len(), 2 * 20);
        for line in &individuals {
            let replication = number(&line["replication"]);
            let mut expected = bits(&line["genes"]);
            let (individual, genes) = (number(&line["individual"]), expected.clone());
            // What it says of its origin leads back to its parent.
            if generation == 0 {
                assert!(line["origin"] == "founder" && line["parent"].is_null(), "{line}");
            } else {
                for bit in line["flipped"].as_array().unwrap() {
                    let bit = number(bit) as usize;
                    expected[bit] = !expected[bit];
                    varied += 1;
                }
                let parent = (replication, generation - 1, number(&line["parent"]));
                assert!(genotypes.get(&parent) == Some(&expected), "{line}");
            }
            let twice = genotypes.insert((replication, generation, individual), genes);
            assert!(twice.is_none(), "{line}");
        }
    }
    assert_eq!(genotypes.len() as u64, 2 * 20 * GENERATIONS);
    assert!(varied > 0);
}

#[test]
fn a_line_of_ancestors_leads_to_a_founder() {
    let place = Place::with_history(GENERATIONS);
    let line = place.ask("history lineage --replication 1");
    assert_eq!((&line[0]["rank"], &line[0]["generation"]), (&0.into(), &(GENERATIONS - 1).into()));
    assert_eq!(line.last().unwrap()["origin"], "founder");
    for pair in line.windows(2) {
        assert_eq!(pair[0]["parent"], pair[1]["individual"]);
        assert_eq!(number(&pair[0]["generation"]), number(&pair[1]["generation"]) + 1);
    }
}
