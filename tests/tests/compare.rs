//! Experiments are compared by their replications.

use selftalk_tests::Place;

#[test]
fn experiments_of_a_history_are_compared() {
    let place = Place::with_history(4);
    assert_eq!(
        place.run("compare").refused(2),
        "it takes two experiments to compare; there is only `small`; run another, or the same with `--set name=...`"
    );
    place.run("run small.toml --set name=other --set generations=3 --set replications=3 --seed 8").done();

    let pairs = place.ask("compare --by fitness --over 2");
    let [pair] = &pairs[..] else { panic!("one pair: {pairs:?}") };
    assert_eq!((&pair["a"], &pair["b"]), (&"small".into(), &"other".into()));
    assert_eq!((&pair["n_a"], &pair["n_b"]), (&2.into(), &3.into()));
    assert_eq!((&pair["first"], &pair["last"]), (&1.into(), &2.into()), "the last ones that both have");
    let values = |experiment: &str| {
        let generations = place.ask(&format!("history generations --experiment {experiment}"));
        let of_one = generations.chunk_by(|a, b| a["replication"] == b["replication"]);
        let mean = |of_one: &[serde_json::Value]| {
            of_one[1..=2].iter().map(|line| line["best_fitness"].as_f64().unwrap()).sum::<f64>() / 2.0
        };
        of_one.map(mean).collect::<Vec<f64>>()
    };
    let (small, other) = (values("small"), values("other"));
    let greater =
        small.iter().flat_map(|a| other.iter().map(move |b| f64::from(u8::from(a > b)))).sum::<f64>();
    assert_eq!(pair["u"].as_f64().unwrap(), greater);
    assert_eq!(pair["median_a"].as_f64().unwrap(), (small[0] + small[1]) / 2.0);
    assert_eq!(pair["p"], pair["p_holm"], "one pair needs no correction");

    assert_eq!(
        place.run("compare small").refused(2),
        "it takes two experiments to compare; named is only `small`; run another, or the same with `--set name=...`"
    );
    assert_eq!(place.run("compare small small").refused(2), "experiment `small` is named twice");
    let message = place.run("compare --generation 3").refused(2);
    assert_eq!(message, "not all replications have generation 3; the last one that all have is 2");
    place.run("compare small none").refused(2);
}
