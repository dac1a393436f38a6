-- Trials in which stored individuals were run afterwards, by which nobody was selected.

PRAGMA user_version = 2;

-- The tests: 'post', post-evaluation in fresh draws without a caretaker; 'generalisation', the places of a grid without a
-- caretaker; 'aided', the same places with one. An individual is named as in `evaluation`.
CREATE TABLE retest (
    replication_id INTEGER NOT NULL,
    generation     INTEGER NOT NULL,
    individual     INTEGER NOT NULL,
    test           TEXT NOT NULL CHECK (test IN ('post', 'generalisation', 'aided')),
    trial          INTEGER NOT NULL CHECK (trial >= 0),
    score          REAL,                       -- null: not a finite number
    success        INTEGER NOT NULL CHECK (success IN (0, 1)),
    steps          INTEGER NOT NULL,           -- control steps of 50 ms the trial lasted
    PRIMARY KEY (replication_id, test, generation, individual, trial),
    FOREIGN KEY (replication_id, generation, individual)
        REFERENCES evaluation (replication_id, generation, individual)
) STRICT, WITHOUT ROWID;

-- A line an individual and test: how often it succeeded, and how long its successes took.
CREATE VIEW retest_summary AS
SELECT experiment.name AS experiment,
       replication.number AS replication,
       retest.test,
       retest.generation,
       retest.individual,
       count(*) AS trials,
       sum(retest.success) AS successes,
       avg(CASE WHEN retest.success THEN retest.steps END) AS steps_to_goal,
       experiment.id AS experiment_id,
       replication.id AS replication_id
FROM experiment
JOIN replication ON replication.experiment_id = experiment.id
JOIN retest ON retest.replication_id = replication.id
GROUP BY replication.id, retest.test, retest.generation, retest.individual;
