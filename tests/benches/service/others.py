"""The same work as `cargo bench -p selftalk-tests --bench service -- cost`, done by other systems.

`others.py ray|dask|hyperqueue [GENERATIONS [BATCH]]`: generations of 1 600 units on two workers, each generation after the
one before. A unit is a function of a genotype of 613 genes that gives 16 outcomes and takes no time. BATCH units are sent
as one task; the systems' documents advise to, 1 is a task a unit. Nothing is stored. Needs ray, dask[distributed] or
hyperqueue, and psutil.
"""

import random
import sys
import time

import psutil

WORKERS = 2
UNITS = 1600
GENES = 613


def evaluate(genotypes, draw):
    """16 outcomes of each genotype: score, success and steps."""
    return [[(g[0] / 256 + draw, g[1] > 127, g[2]) for _ in range(16)] for g in genotypes]


def tasks(generation, batch):
    dice = random.Random(generation)
    genotypes = [dice.randbytes(2 * GENES) for _ in range(UNITS)]
    return [genotypes[first : first + batch] for first in range(0, UNITS, batch)]


def with_ray(run):
    import ray

    ray.init(num_cpus=WORKERS, include_dashboard=False, log_to_driver=False)
    remote = ray.remote(evaluate)
    # The workers' processes start with the first tasks.
    ray.get([remote.remote([], 0) for _ in range(8)])
    run(lambda parts, draw: ray.get([remote.remote(part, draw) for part in parts]))
    ray.shutdown()


def with_dask(run):
    from distributed import Client, LocalCluster

    with LocalCluster(n_workers=WORKERS, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        run(lambda parts, draw: client.gather(client.map(evaluate, parts, draw=draw, pure=False)))


def with_hyperqueue(run):
    from hyperqueue import Client, Job, LocalCluster
    from hyperqueue.cluster import WorkerConfig

    with LocalCluster() as cluster:
        for _ in range(WORKERS):
            cluster.start_worker(WorkerConfig(cores=1))
        client = Client(cluster.server_dir) if hasattr(cluster, "server_dir") else cluster.client()

        def generation(parts, draw):
            # Results would come back in files; that they are waited for is enough here.
            job = Job()
            for part in parts:
                job.function(evaluate, args=(part, draw))
            client.wait_for_jobs([client.submit(job)])

        run(generation)


def processor():
    """Processor time of this process and all it has started, in seconds."""
    total = 0.0
    me = psutil.Process()
    for process in [me, *me.children(recursive=True)]:
        try:
            times = process.cpu_times()
        except psutil.NoSuchProcess:
            continue
        total += times.user + times.system + times.children_user + times.children_system
    return total


def main():
    if __name__ != "__main__":
        return
    system = sys.argv[1]
    generations = int(sys.argv[2]) if len(sys.argv) > 2 else 100
    batch = int(sys.argv[3]) if len(sys.argv) > 3 else 1

    def run(evaluate_all):
        evaluate_all(tasks(0, UNITS // 8), 0)
        begin, before = time.monotonic(), processor()
        for generation in range(generations):
            evaluate_all(tasks(generation, batch), generation)
        wall, used = time.monotonic() - begin, processor() - before
        units = generations * UNITS
        print(f"{system}, tasks of {batch}: units: {units}, wall: {wall:.2f} s, processor: {used:.2f} s")
        print(f"a unit: wall {1e6 * wall / units:.1f} us, processor {1e6 * used / units:.1f} us", flush=True)

    {"ray": with_ray, "dask": with_dask, "hyperqueue": with_hyperqueue}[system](run)


main()
