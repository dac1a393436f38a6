-- What the best individual came to, beside its generation, so that a question about all generations needs no other rows.

PRAGMA user_version = 4;

ALTER TABLE generation ADD COLUMN best_fitness REAL NOT NULL DEFAULT 0;
ALTER TABLE generation ADD COLUMN best_successes INTEGER NOT NULL DEFAULT 0;

UPDATE generation SET (best_fitness, best_successes) = (
    SELECT evaluation.fitness, evaluation.successes
    FROM individual
    CROSS JOIN evaluation ON evaluation.replication_id = individual.replication_id
        AND evaluation.generation = individual.generation AND evaluation.individual = individual.evaluated_as
    WHERE individual.replication_id = generation.replication_id
        AND individual.generation = generation.number AND individual.number = generation.best_individual);

DROP VIEW generation_summary;
CREATE VIEW generation_summary AS
SELECT experiment.name AS experiment,
       replication.number AS replication,
       generation.number AS generation,
       generation.best_fitness,
       generation.mean_fitness,
       generation.best_successes,
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
JOIN generation ON generation.replication_id = replication.id;
