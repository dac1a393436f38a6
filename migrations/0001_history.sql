-- The history of experiments. What a committed generation wrote never changes.
-- Times are RFC 3339 text in UTC. Everything is counted from 0.
-- Tables WITHOUT ROWID are keyed by what people call the thing, which is also the order it is read in.

PRAGMA user_version = 1;

-- An experiment: one condition, run in several replications.
CREATE TABLE experiment (
    id          INTEGER PRIMARY KEY,
    name        TEXT NOT NULL UNIQUE,
    settings    TEXT NOT NULL,                 -- the complete experiment file, TOML
    fingerprint TEXT NOT NULL,                 -- of the simulator it was begun with
    created_at  TEXT NOT NULL
) STRICT;

CREATE TABLE replication (
    id            INTEGER PRIMARY KEY,
    experiment_id INTEGER NOT NULL REFERENCES experiment (id),
    number        INTEGER NOT NULL CHECK (number >= 0),
    finished_at   TEXT,                        -- null while generations are left to run
    UNIQUE (experiment_id, number)
) STRICT;

-- A worker's connection to a master.
CREATE TABLE worker (
    id        INTEGER PRIMARY KEY,
    name      TEXT NOT NULL,
    host      TEXT NOT NULL,
    process   INTEGER NOT NULL,                -- process id on that host
    version   TEXT NOT NULL,
    slots     INTEGER NOT NULL,                -- threads that run trials
    joined_at TEXT NOT NULL,
    left_at   TEXT                             -- null while connected, or when the master was killed meanwhile
) STRICT;

CREATE TABLE generation (
    replication_id      INTEGER NOT NULL REFERENCES replication (id),
    number              INTEGER NOT NULL CHECK (number >= 0),
    best_individual     INTEGER NOT NULL,
    mean_fitness        REAL NOT NULL,
    most_successes      INTEGER NOT NULL,      -- successful trials of the most successful individual
    optimal_individuals INTEGER NOT NULL,      -- individuals that succeeded in all trials
    distinct_genotypes  INTEGER NOT NULL,
    genotypes_sha256    BLOB NOT NULL CHECK (length(genotypes_sha256) = 32),  -- of all individuals' genes in order
    wall_ms             INTEGER NOT NULL,      -- wall time the generation took
    committed_at        TEXT NOT NULL,
    PRIMARY KEY (replication_id, number)
) STRICT, WITHOUT ROWID;

CREATE INDEX generation_optimal ON generation (replication_id, number) WHERE optimal_individuals > 0;

-- Each distinct genotype of a generation is evaluated once, under the number of the first individual carrying it.
CREATE TABLE evaluation (
    replication_id INTEGER NOT NULL,
    generation     INTEGER NOT NULL,
    individual     INTEGER NOT NULL CHECK (individual >= 0),
    fitness        REAL NOT NULL,
    successes      INTEGER NOT NULL,
    worker_id      INTEGER REFERENCES worker (id),
    failure        TEXT,                       -- why there are no real outcomes, if it was given up
    PRIMARY KEY (replication_id, generation, individual),
    FOREIGN KEY (replication_id, generation) REFERENCES generation (replication_id, number)
) STRICT, WITHOUT ROWID;

CREATE TABLE trial (
    replication_id INTEGER NOT NULL,
    generation     INTEGER NOT NULL,
    individual     INTEGER NOT NULL,
    trial          INTEGER NOT NULL CHECK (trial >= 0),
    score          REAL,                       -- null: not a finite number
    success        INTEGER NOT NULL CHECK (success IN (0, 1)),
    steps          INTEGER NOT NULL,           -- control steps of 50 ms the trial lasted
    PRIMARY KEY (replication_id, generation, individual, trial),
    FOREIGN KEY (replication_id, generation, individual)
        REFERENCES evaluation (replication_id, generation, individual)
) STRICT, WITHOUT ROWID;

CREATE TABLE individual (
    replication_id INTEGER NOT NULL,
    generation     INTEGER NOT NULL,
    number         INTEGER NOT NULL CHECK (number >= 0),
    parent         INTEGER,                    -- number in the previous generation; null: a founder
    flipped        TEXT,                       -- JSON array of the bits that differ from the parent; null: not varied
    evaluated_as   INTEGER NOT NULL,           -- the first individual with the same genotype, often itself
    rank           INTEGER NOT NULL CHECK (rank >= 0),
    PRIMARY KEY (replication_id, generation, number),
    FOREIGN KEY (replication_id, generation, evaluated_as)
        REFERENCES evaluation (replication_id, generation, individual)
) STRICT, WITHOUT ROWID;

-- The distinct genotypes of the founders, and of a later generation every so often, whole. All others are their
-- parent's genes with the flipped bits.
CREATE TABLE genotype (
    replication_id INTEGER NOT NULL,
    generation     INTEGER NOT NULL,
    individual     INTEGER NOT NULL,
    genes          BLOB NOT NULL,              -- 16 bits a gene, little-endian
    PRIMARY KEY (replication_id, generation, individual),
    FOREIGN KEY (replication_id, generation, individual)
        REFERENCES evaluation (replication_id, generation, individual)
) STRICT;

-- A line a generation: what it came to.
CREATE VIEW generation_summary AS
SELECT experiment.name AS experiment,
       replication.number AS replication,
       generation.number AS generation,
       best.fitness AS best_fitness,
       generation.mean_fitness,
       best.successes AS best_successes,
       generation.most_successes,
       generation.optimal_individuals,
       generation.distinct_genotypes,
       generation.best_individual,
       generation.wall_ms,
       generation.committed_at,
       experiment.id AS experiment_id,
       replication.id AS replication_id
FROM experiment
JOIN replication ON replication.experiment_id = experiment.id
JOIN generation ON generation.replication_id = replication.id
JOIN individual ON individual.replication_id = generation.replication_id
    AND individual.generation = generation.number AND individual.number = generation.best_individual
JOIN evaluation AS best ON best.replication_id = individual.replication_id
    AND best.generation = individual.generation AND best.individual = individual.evaluated_as;

-- A line an individual: where it comes from and what it came to.
CREATE VIEW individual_summary AS
SELECT experiment.name AS experiment,
       replication.number AS replication,
       individual.generation,
       individual.number AS individual,
       individual.rank,
       evaluation.fitness,
       evaluation.successes,
       CASE WHEN individual.parent IS NULL THEN 'founder'
            WHEN individual.flipped IS NULL THEN 'elite'
            ELSE 'varied' END AS origin,
       individual.parent,
       individual.flipped,
       individual.evaluated_as,
       worker.name AS worker,
       evaluation.failure,
       experiment.id AS experiment_id,
       replication.id AS replication_id
FROM experiment
JOIN replication ON replication.experiment_id = experiment.id
JOIN individual ON individual.replication_id = replication.id
JOIN evaluation ON evaluation.replication_id = individual.replication_id
    AND evaluation.generation = individual.generation AND evaluation.individual = individual.evaluated_as
LEFT JOIN worker ON worker.id = evaluation.worker_id;

-- The best individual of every generation.
CREATE VIEW best_individual AS
SELECT individual_summary.*
FROM generation
JOIN individual_summary ON individual_summary.replication_id = generation.replication_id
    AND individual_summary.generation = generation.number
    AND individual_summary.individual = generation.best_individual;

-- A line a trial of every individual, whether it was evaluated itself or shares another's result.
CREATE VIEW trial_outcome AS
SELECT individual_summary.experiment,
       individual_summary.replication,
       individual_summary.generation,
       individual_summary.individual,
       trial.trial,
       trial.score,
       trial.success,
       trial.steps,
       individual_summary.experiment_id,
       individual_summary.replication_id
FROM individual_summary
JOIN trial ON trial.replication_id = individual_summary.replication_id
    AND trial.generation = individual_summary.generation AND trial.individual = individual_summary.evaluated_as;
