//! What was written is what is read.

use std::sync::Arc;

use selftalk_sim::Behaviour;

use super::*;
use crate::store::{MemoryStore, ReplicationState, SqliteStore, Unproven, WorkerInfo};

async fn fresh() -> (tempfile::TempDir, SqliteStore) {
    let folder = tempfile::tempdir().unwrap();
    let store = SqliteStore::open_writer(&folder.path().join("a.db")).await.unwrap();
    (folder, store)
}

#[tokio::test]
async fn every_generation_reads_back_equal() {
    let (folder, store) = fresh().await;
    let experiment = experiment("a");
    let written = run(&store, &experiment, 130).await;
    store.close().await.unwrap();

    let reader = SqliteStore::open_reader(&folder.path().join("a.db")).await.unwrap();
    let stored = reader.experiment("a").await.unwrap().unwrap();
    assert_eq!(stored.experiment, experiment);
    assert_eq!(stored.state(), ReplicationState::Finished);
    for (replication, written) in stored.replications.iter().zip(&written) {
        let mut generations = reader.generations(replication);
        for (generation, record) in (0..).zip(written) {
            assert_eq!(generations.read(generation).await.unwrap(), *record, "in order: {generation}");
        }
        for generation in [129, 0, 51, 49, 50, 51, 12, 13, 99] {
            let mut single = reader.generations(replication);
            assert_eq!(single.read(generation).await.unwrap(), written[generation as usize], "{generation}");
            assert_eq!(
                generations.read(generation).await.unwrap(),
                written[generation as usize],
                "{generation}"
            );
        }
        assert!(generations.read(130).await.is_err());
    }
}

#[tokio::test]
async fn what_the_best_came_to_is_told_by_behaviour() {
    let (_folder, store) = fresh().await;
    let written = run(&store, &experiment("a"), 30).await;
    for (replication, written) in
        store.experiment("a").await.unwrap().unwrap().replications.iter().zip(&written)
    {
        let told = store.list_behaviours(replication.id).await.unwrap();
        let expected = written.iter().map(|record| record.behaviours(Task::Elementary));
        assert!(told.iter().cloned().eq((0..).zip(expected)));
        // More than one question has room for, and nothing after the last generation.
        let bins: Vec<_> = (0..150).map(|bin| bin % 25..=bin % 25 + 9).collect();
        let sums = store.sum_behaviours(replication.id, &Behaviour::ALL, &bins).await.unwrap();
        assert_eq!(sums.len(), bins.len());
        for (sums, bin) in sums.iter().zip(bins) {
            let told: Vec<_> = told.iter().filter(|(generation, _)| bin.contains(generation)).collect();
            assert_eq!(sums.len(), 4);
            for (at, sum) in sums.iter().enumerate() {
                let parts: Vec<_> = told.iter().map(|(_, behaviours)| behaviours[at]).collect();
                let score = parts.iter().map(|part| part.score).sum::<f64>() / parts.len() as f64;
                assert_eq!((sum.behaviour, sum.trials), (Behaviour::ALL[at], 4 * parts.len() as u32));
                assert_eq!(sum.successes, parts.iter().map(|part| part.successes).sum::<u32>());
                assert!((sum.score - score).abs() < 1e-12, "{sum:?}, {score}");
            }
        }
    }
}

#[tokio::test]
async fn a_replication_goes_on_where_it_stopped() {
    let (folder, store) = fresh().await;
    let experiment = experiment("a");
    run(&store, &experiment, 7).await;
    store.close().await.unwrap();
    let store = SqliteStore::open_writer(&folder.path().join("a.db")).await.unwrap();
    run(&store, &experiment, 5).await;

    let unbroken = MemoryStore::new();
    let expected = run(&unbroken, &experiment, 12).await;
    let stored = store.experiment("a").await.unwrap().unwrap();
    for (replication, expected) in stored.replications.iter().zip(expected) {
        assert_eq!(replication.generations, 12);
        let mut generations = store.generations(replication);
        for (generation, record) in (0..).zip(expected) {
            assert_eq!(generations.read(generation).await.unwrap(), record);
        }
    }
}

#[tokio::test]
async fn both_stores_tell_the_same() {
    let (_folder, store) = fresh().await;
    let memory = MemoryStore::new();
    let mut experiment = experiment("a");
    experiment.generations = 9;
    run(&store, &experiment, 9).await;
    run(&memory, &experiment, 9).await;
    let a = store.experiment("a").await.unwrap().unwrap();
    let b = memory.experiment("a").await.unwrap().unwrap();
    for (a, b) in a.replications.iter().zip(&b.replications) {
        assert_eq!((a.number, a.finished, a.generations), (b.number, b.finished, b.generations));
        assert_eq!((a.last, a.first_optimal), (b.last, b.first_optimal));
        assert_eq!(a.state(), ReplicationState::Finished);
        let resumed = store.last_generation(a.id).await.unwrap();
        assert_eq!(resumed, memory.last_generation(b.id).await.unwrap());
    }
}

/// Takes generations of the first replication back, past a keyframe and past its end, and runs it again.
async fn take_back_and_go_on(store: &impl Store, experiment: &Experiment) {
    let before = run(store, experiment, 60).await;
    let id = store.experiment("a").await.unwrap().unwrap().replications[0].id;
    store.take_back(id, 60).await.unwrap();
    assert!(store.experiment("a").await.unwrap().unwrap().replications[0].generations == 60);
    store.take_back(id, 47).await.unwrap();
    let stored = store.experiment("a").await.unwrap().unwrap();
    let [taken, other] = &stored.replications[..] else { panic!("two replications") };
    assert_eq!((taken.generations, taken.finished, taken.last), (47, false, before[0][46].summary()));
    assert_eq!((other.generations, other.finished), (60, true));
    for expected in &before[0][47..] {
        let record = next(store, experiment, id, 0).await;
        assert_eq!(record, *expected);
        commit(store, id, &record, record.population.generation == 59).await.unwrap();
    }
    store.take_back(id, 0).await.unwrap();
    assert_eq!(store.last_generation(id).await.unwrap(), None);
    assert_eq!(next(store, experiment, id, 0).await, before[0][0]);
}

#[tokio::test]
async fn what_is_taken_back_is_gone_and_the_replication_goes_on_before_it() {
    let (_folder, store) = fresh().await;
    let experiment = Experiment { generations: 60, ..experiment("a") };
    take_back_and_go_on(&store, &experiment).await;
    take_back_and_go_on(&MemoryStore::new(), &experiment).await;
    let other = store.experiment("a").await.unwrap().unwrap().replications.remove(1);
    let reader = store.generations(&other).read(59).await;
    assert!(reader.is_ok(), "the other replication is untouched");
}

#[tokio::test]
async fn optimal_individuals_and_the_summary_are_those_of_the_generation() {
    let (_folder, store) = fresh().await;
    let experiment = experiment("a");
    let id = store.create_experiment(&experiment, "sim-1").await.unwrap().replications[0].id;
    for generation in 0..3 {
        let mut record = next(&store, &experiment, id, 0).await;
        if generation > 0 {
            let same = record.evaluated[1].member;
            record.evaluated[1].outcomes.iter_mut().for_each(|outcome| outcome.success = true);
            let population = &record.population.members;
            for (member, scored) in population.iter().zip(&mut record.scored) {
                if member.genotype == population[same as usize].genotype {
                    scored.successes = 16;
                }
            }
        }
        commit(&store, id, &record, false).await.unwrap();
        let stored = store.experiment("a").await.unwrap().unwrap();
        let last = stored.replications[0].last.unwrap();
        let best = record.scored[record.ranking[0] as usize];
        assert_eq!((last.best_fitness, last.best_successes), (best.fitness, best.successes));
        assert_eq!(last.distinct as usize, record.evaluated.len());
        assert_eq!(stored.replications[0].first_optimal, (generation > 0).then_some(1));
        assert_eq!(last.most_successes == 16, generation > 0);
        let optimal = record.scored.iter().filter(|scored| scored.successes == 16).count();
        assert_eq!(last.optimal as usize, optimal);
    }
    let stored = store.experiment("a").await.unwrap().unwrap();
    assert_eq!(stored.state(), ReplicationState::Running);
    assert_eq!(stored.replications[1].last, None);
}

fn worker(name: &str) -> WorkerInfo {
    let (name, host, version) = (name.to_owned(), "h".to_owned(), "1".to_owned());
    WorkerInfo { name, host, process: 7, version, slots: 2 }
}

/// Two workers contribute to two replications, are looked into, and some of it is taken back.
async fn look_into_workers(store: &impl Store) {
    let experiment = experiment("a");
    let stored = store.create_experiment(&experiment, "sim-1").await.unwrap();
    let [first, second] = [0, 1].map(|number: usize| stored.replications[number].id);
    let steady = store.worker_joined(&worker("steady")).await.unwrap();
    let late = store.worker_joined(&worker("late")).await.unwrap();
    assert_eq!(store.unproven().await.unwrap(), [], "they have answered nothing");

    let beginning = evaluate(founders(&experiment, GENES, 0), Some(steady));
    commit(store, first, &beginning, false).await.unwrap();
    let offspring = reproduce(&experiment, &beginning.population, &beginning.ranking);
    let mut shared = evaluate(offspring, Some(steady));
    shared.evaluated.last_mut().unwrap().worker = Some(late);
    commit(store, first, &shared, false).await.unwrap();
    let other = evaluate(founders(&experiment, GENES, 1), Some(late));
    commit(store, second, &other, false).await.unwrap();

    let answer = |worker, name: &str, replication, record: &GenerationRecord, from_last: usize, since| {
        let evaluated = &record.evaluated[record.evaluated.len() - 1 - from_last];
        let member = &record.population.members[evaluated.member as usize];
        Unproven {
            worker,
            name: name.to_owned(),
            experiment: stored.id,
            replication,
            generation: record.population.generation,
            genotype: Arc::clone(&member.genotype),
            outcomes: evaluated.outcomes.clone(),
            since,
        }
    };
    let of_steady = answer(steady, "steady", 0, &shared, 1, vec![(first, 0)]);
    let of_late = answer(late, "late", 1, &other, 0, vec![(first, 1), (second, 0)]);
    assert_eq!(store.unproven().await.unwrap(), [of_steady.clone(), of_late]);
    store.workers_audited(&[late]).await.unwrap();
    assert_eq!(store.unproven().await.unwrap(), [of_steady]);
    store.take_back(first, 1).await.unwrap();
    let before = answer(steady, "steady", 0, &beginning, 0, vec![(first, 0)]);
    assert_eq!(store.unproven().await.unwrap(), [before]);
}

#[tokio::test]
async fn the_last_answers_that_nobody_has_looked_into_are_known() {
    let (_folder, store) = fresh().await;
    look_into_workers(&store).await;
    look_into_workers(&MemoryStore::new()).await;
}

#[tokio::test]
async fn failures_workers_and_scores_beyond_numbers_are_kept() {
    let (_folder, store) = fresh().await;
    let worker = store.worker_joined(&worker("w")).await.unwrap();
    let experiment = experiment("a");
    let stored = store.create_experiment(&experiment, "sim-1").await.unwrap();
    let mut record = evaluate(founders(&experiment, GENES, 1), Some(worker));
    record.evaluated[3].failure = Some("lost 5 workers".to_owned());
    record.evaluated[3].outcomes[2].score = f64::INFINITY;
    commit(&store, stored.replications[1].id, &record, false).await.unwrap();
    store.worker_left(worker).await.unwrap();
    let read = store.generations(&stored.replications[1]).read(0).await.unwrap();
    assert_eq!(read.evaluated[0], record.evaluated[0]);
    assert_eq!(read.evaluated[3].failure, record.evaluated[3].failure);
    assert!(read.evaluated[3].outcomes[2].score.is_nan());
}

#[tokio::test]
async fn what_does_not_fit_is_refused_and_leaves_nothing() {
    let (_folder, store) = fresh().await;
    let experiment = experiment("a");
    let id = store.create_experiment(&experiment, "sim-1").await.unwrap().replications[0].id;
    let good = next(&store, &experiment, id, 0).await;
    let later = evaluate(reproduce(&experiment, &good.population, &good.ranking), None);
    let other = evaluate(founders(&experiment, GENES, 1), None);
    let mut unranked = good.clone();
    unranked.ranking[0] = unranked.ranking[1];
    let mut unevaluated = good.clone();
    unevaluated.evaluated.pop();
    let mut unscored = good.clone();
    unscored.scored[5].fitness = f64::NAN;
    for bad in [&later, &other, &unranked, &unevaluated, &unscored] {
        let error = commit(&store, id, bad, false).await.unwrap_err();
        assert!(matches!(error, StoreError::Commit { .. }), "{error}");
        assert_eq!(store.last_generation(id).await.unwrap(), None);
    }
    commit(&store, id, &good, false).await.unwrap();
    assert!(commit(&store, id, &good, false).await.is_err(), "the same generation twice");
    commit(&store, id, &later, true).await.unwrap();
    let after = next(&store, &experiment, id, 0).await;
    let error = commit(&store, id, &after, false).await.unwrap_err();
    assert!(error.to_string().contains("finished"), "{error}");
}

#[tokio::test]
async fn a_name_is_taken_once() {
    let (_folder, store) = fresh().await;
    store.create_experiment(&experiment("a"), "sim-1").await.unwrap();
    store.create_experiment(&experiment("b"), "sim-1").await.unwrap();
    let error = store.create_experiment(&experiment("a"), "sim-1").await.unwrap_err();
    assert!(matches!(error, StoreError::Exists { .. }), "{error}");
    let names: Vec<_> = store.experiments().await.unwrap().into_iter().map(|e| e.experiment.name).collect();
    assert_eq!(names, ["a", "b"]);
    assert_eq!(store.experiment("c").await.unwrap(), None);
}
