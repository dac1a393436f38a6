-- What the best individual came to in each behaviour, so that a question about all generations needs no trials.

PRAGMA user_version = 5;

-- Keyed so that the generations of a behaviour lie side by side.
CREATE TABLE best_behaviour (
    replication_id INTEGER NOT NULL,
    behaviour      TEXT NOT NULL,              -- reach, open, grasp, move or move-to-target
    generation     INTEGER NOT NULL,
    trials         INTEGER NOT NULL CHECK (trials > 0),
    successes      INTEGER NOT NULL,
    score          REAL NOT NULL,              -- mean of the trials; a score that is not a finite number counts as 0
    PRIMARY KEY (replication_id, behaviour, generation),
    FOREIGN KEY (replication_id, generation) REFERENCES generation (replication_id, number)
) STRICT, WITHOUT ROWID;

INSERT INTO best_behaviour
SELECT generation.replication_id,
       CASE WHEN instr(experiment.settings, 'task = "move-to-target"') > 0 THEN 'move-to-target'
            WHEN trial.trial < 4 THEN 'reach'
            WHEN trial.trial < 8 THEN 'open'
            WHEN trial.trial < 12 THEN 'grasp'
            ELSE 'move' END AS behaviour,
       generation.number,
       count(*),
       sum(trial.success),
       avg(coalesce(trial.score, 0.0))
FROM experiment
CROSS JOIN replication ON replication.experiment_id = experiment.id
CROSS JOIN generation ON generation.replication_id = replication.id
CROSS JOIN individual ON individual.replication_id = generation.replication_id
    AND individual.generation = generation.number AND individual.number = generation.best_individual
CROSS JOIN trial ON trial.replication_id = individual.replication_id
    AND trial.generation = individual.generation AND trial.individual = individual.evaluated_as
GROUP BY generation.replication_id, behaviour, generation.number;

-- A line a generation and behaviour.
CREATE VIEW behaviour_summary AS
SELECT experiment.name AS experiment,
       replication.number AS replication,
       best_behaviour.generation,
       best_behaviour.behaviour,
       best_behaviour.trials,
       best_behaviour.successes,
       best_behaviour.score,
       experiment.id AS experiment_id,
       replication.id AS replication_id
FROM experiment
JOIN replication ON replication.experiment_id = experiment.id
JOIN best_behaviour ON best_behaviour.replication_id = replication.id;
