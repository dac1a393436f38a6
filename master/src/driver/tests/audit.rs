//! Workers whose answers are wrong.

use super::*;

const FOR_EVER: (usize, Option<FromWorker>) = (usize::MAX, None);

/// Works like a worker, but some answers are wrong in their last bit, until it is sent away or has answered enough: then
/// it says a last word or, if it has none, stays and answers no more. Returns whether it was sent away.
async fn lie(
    site: &Site,
    instance: u64,
    (enough, last_word): (usize, Option<FromWorker>),
    wrong: impl Fn(usize) -> bool,
) -> bool {
    let experiment = small(&[]);
    let simulator = Simulator::new(&experiment).unwrap();
    let (mut answered, mut given) = (0, 0);
    let mut answer = |unit: Unit| {
        let mut outcomes = simulator.evaluate(&unit.genotype, unit.draw, unit.trials).unwrap();
        if wrong(answered) {
            outcomes[0].score = f64::from_bits(outcomes[0].score.to_bits() ^ 1);
        }
        answered += 1;
        UnitResult { key: unit.key, answer: Answer::Outcomes(outcomes) }
    };
    let heard =
        talk(site, FromWorker::Hello(Hello { instance, ..hello() }).into(), |message| match message {
            FromMaster::Lease(_) if given >= enough => Some(Vec::new()),
            FromMaster::Lease(units) => {
                given += units.len();
                let results = units.iter().cloned().map(&mut answer).collect();
                let last_word = last_word.clone().filter(|_| given >= enough);
                Some([FromWorker::Results(results)].into_iter().chain(last_word).collect())
            }
            FromMaster::Farewell { .. } | FromMaster::Refusal { .. } => None,
            _ => Some(Vec::new()),
        })
        .await;
    matches!(heard.last(), Some(FromMaster::Refusal { reason: RefusalReason::Wrong, .. }))
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_worker_with_wrong_bits_is_sent_away_and_leaves_nothing_behind() {
    let experiment = small(&[]);
    let folder = TempDir::new().unwrap();
    let site = Site::auditing(folder.path(), &experiment, ANYWHERE, 0.3).await;
    assert!(lie(&site, 1, FOR_EVER, |_| true).await);
    assert!(lie(&site, 1, FOR_EVER, |_| false).await, "it does not get in again");
    let honest = site.worker(1);
    assert_eq!(site.end().await, RunEnd::Finished);
    assert_eq!(honest.end().await, End::Finished);
    assert!(history(folder.path()).await == undisturbed(&experiment).await);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn committed_generations_are_taken_back_when_they_were_wrong() {
    let experiment = small(&[]);
    let folder = TempDir::new().unwrap();
    // So small a share that only its leave makes anyone look into what a worker said.
    let mut site = Site::auditing(folder.path(), &experiment, ANYWHERE, 1e-6).await;
    assert!(
        !lie(&site, 1, (130, Some(FromWorker::Goodbye)), |_| true).await,
        "it leaves before anyone has noticed"
    );
    let taken_back = |board: &Board| board.standings.iter().all(|standing| standing.generations == 0);
    timeout(FOREVER, site.board.wait_for(taken_back)).await.expect("nothing is taken back").unwrap();
    let honest = site.worker(1);
    assert_eq!(site.end().await, RunEnd::Finished);
    assert_eq!(honest.end().await, End::Finished);
    assert!(history(folder.path()).await == undisturbed(&experiment).await);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_run_does_not_finish_before_its_last_answers_were_looked_into() {
    let experiment = small(&[]);
    let folder = TempDir::new().unwrap();
    let site = Site::auditing(folder.path(), &experiment, ANYWHERE, 1e-6).await;
    // It does all the work, and is found out at the very end.
    assert!(lie(&site, 1, FOR_EVER, |number| number > 20).await);
    let honest = site.worker(2);
    assert_eq!(site.end().await, RunEnd::Finished);
    assert_eq!(honest.end().await, End::Finished);
    assert!(history(folder.path()).await == undisturbed(&experiment).await);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_a_master_did_not_come_to_is_looked_into_by_the_next_one() {
    let experiment = small(&[]);
    let folder = TempDir::new().unwrap();
    // So small a share that nobody looks into anything before the end.
    let site = Site::auditing(folder.path(), &experiment, ANYWHERE, 1e-6).await;
    let (mut board, shutdown) = (site.board.clone(), site.shutdown.clone());
    let under_way =
        |board: &Board| board.standings.iter().map(|standing| standing.generations).sum::<u32>() >= 2;
    let stop = async {
        timeout(FOREVER, board.wait_for(under_way)).await.expect("no progress").unwrap();
        shutdown.cancel();
    };
    let (caught, ()) = tokio::join!(lie(&site, 1, (130, None), |_| true), stop);
    assert!(!caught);
    assert_eq!(site.end().await, RunEnd::Interrupted);

    let site = Site::auditing(folder.path(), &experiment, ANYWHERE, 1e-6).await;
    assert!(site.board.borrow().standings.iter().all(|standing| standing.generations == 0));
    let honest = site.worker(1);
    assert_eq!(site.end().await, RunEnd::Finished);
    assert_eq!(honest.end().await, End::Finished);
    assert!(history(folder.path()).await == undisturbed(&experiment).await);
    let store = SqliteStore::open_reader(&folder.path().join("history.db")).await.unwrap();
    assert_eq!(store.unproven().await.unwrap(), [], "a finished run leaves no doubts");
}
