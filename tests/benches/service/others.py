"""What the service takes for a unit of work beside general task systems, without a simulator.

    python tests/benches/service/others.py [--generations N] [SYSTEM ...]

Run it from the root of the repository, with the Python of an environment with `tests/benches/service/requirements.txt`; `just
others` does. Systems: selftalk, ray, dask, hyperqueue; the first by `cargo bench --bench service -- cost`, the others here.

A unit is a genotype of 1226 bytes that goes out, a hash of it, and 16 scores that come back. A generation is 1600 units, and the
next begins when all scores of the last are in. There are two workers, one a core, on this machine. The others keep nothing, where
selftalk selects and varies genotypes, draws trials, and writes everything to its database.

Ray and Dask are measured twice: with a task a unit, which is what can be lost and repeated one by one, and with a task for 50
units, as both advise for work as small as this. HyperQueue's tasks are programs: it runs `true`, and no scores come back.

Printed is processor time a unit, of all processes together, and wall time a unit. selftalk is measured over 100 generations, from
the start of its programs to their end; the others over those that are asked for, after one to warm up.
"""

import argparse
import hashlib
import importlib.metadata
import os
import re
import subprocess
import sys
import tempfile
import time

import psutil

UNITS = 1600
GENES = 1226
TRIALS = 16
CHUNK = 50
WORKERS = 2
# Start and end of its programs are in what is measured.
GENERATIONS_OF_SELFTALK = 100
HEADER = "| system | processor time a unit, µs | wall time a unit, µs |\n|---|---|---|\n"


def evaluate(genotype):
    """16 scores in [0, 1] of a genotype."""
    digest = hashlib.blake2b(genotype, digest_size=2 * TRIALS).digest()
    return [int.from_bytes(digest[2 * i : 2 * i + 2], "little") / 65535 for i in range(TRIALS)]


def evaluate_all(genotypes):
    return [evaluate(genotype) for genotype in genotypes]


def population():
    return [os.urandom(GENES) for _ in range(UNITS)]


def chunks(units):
    return [units[i : i + CHUNK] for i in range(0, len(units), CHUNK)]


def processor_time():
    """Seconds of this process and all below it, ended ones included where their parents waited for them."""
    total, this = 0.0, psutil.Process()
    for process in [this, *this.children(recursive=True)]:
        try:
            times = process.cpu_times()
        except psutil.NoSuchProcess:
            continue
        total += times.user + times.system + times.children_user + times.children_system
    return total


def measure(name, generation, generations):
    """Runs `generation`, once to warm up, then some times; a row of the table."""
    generation()
    before, begin = processor_time(), time.perf_counter()
    for _ in range(generations):
        generation()
    used, wall = processor_time() - before, time.perf_counter() - begin
    units = generations * UNITS
    return name, 1e6 * used / units, 1e6 * wall / units


def check(scores):
    if len(scores) != UNITS or any(len(unit) != TRIALS for unit in scores):
        sys.exit("scores are missing")


def with_selftalk(_):
    command = ["cargo", "bench", "--workspace", "--bench", "service", "--", "cost", str(GENERATIONS_OF_SELFTALK)]
    printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    wall, processor = re.search(r"a unit: wall ([0-9.]+) us, processor ([0-9.]+) us", printed).groups()
    yield f"selftalk, {GENERATIONS_OF_SELFTALK} generations", float(processor), float(wall)


def with_ray(generations):
    import ray

    ray.init(num_cpus=WORKERS, include_dashboard=False, log_to_driver=False, logging_level="error")
    one, many = ray.remote(evaluate), ray.remote(evaluate_all)
    version = importlib.metadata.version("ray")
    yield measure(
        f"Ray {version}, a task a unit",
        lambda: check(ray.get([one.remote(genotype) for genotype in population()])),
        generations,
    )
    yield measure(
        f"Ray {version}, a task for {CHUNK}",
        lambda: check(sum(ray.get([many.remote(chunk) for chunk in chunks(population())]), [])),
        generations,
    )
    ray.shutdown()


def with_dask(generations):
    from dask.distributed import Client, LocalCluster

    version = importlib.metadata.version("distributed")
    with LocalCluster(n_workers=WORKERS, threads_per_worker=1, dashboard_address=None) as cluster:
        with Client(cluster) as client:
            yield measure(
                f"Dask {version}, a task a unit",
                lambda: check(client.gather(client.map(evaluate, population(), pure=False))),
                generations,
            )
            yield measure(
                f"Dask {version}, a task for {CHUNK}",
                lambda: check(sum(client.gather(client.map(evaluate_all, chunks(population()), pure=False)), [])),
                generations,
            )


def with_hyperqueue(generations):
    from hyperqueue import Job, LocalCluster
    from hyperqueue.cluster import WorkerConfig

    version = importlib.metadata.version("hyperqueue")
    with tempfile.TemporaryDirectory() as folder, LocalCluster(folder, WorkerConfig(cores=WORKERS)) as cluster:
        client = cluster.client()

        def generation():
            job = Job(folder, default_env={})
            for _ in range(UNITS):
                job.program(["true"], stdout=None, stderr=None)
            client.wait_for_jobs([client.submit(job)])

        yield measure(f"HyperQueue {version}, `true` a unit", generation, generations)


def main():
    systems = {"selftalk": with_selftalk, "ray": with_ray, "dask": with_dask, "hyperqueue": with_hyperqueue}
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--generations", type=int, default=100)
    parser.add_argument("systems", nargs="*", metavar="SYSTEM", help=", ".join(systems))
    options = parser.parse_args()
    unknown = [name for name in options.systems if name not in systems]
    if unknown:
        parser.error(f"no system {unknown[0]!r}; there are {', '.join(systems)}")
    names = options.systems or list(systems)
    if len(names) == 1:
        # The systems write what they like while they run.
        measured = systems[names[0]](options.generations)
        rows = [f"| {name} | {processor:.0f} | {wall:.0f} |" for name, processor, wall in measured]
    else:
        # Each in a process of its own: what one leaves in memory, another's children would begin with.
        rows = []
        for name in names:
            command = [sys.executable, __file__, "--generations", str(options.generations), name]
            printed = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
            rows += printed.split(HEADER)[1].splitlines()
    print(HEADER + "\n".join(rows))


if __name__ == "__main__":
    main()
