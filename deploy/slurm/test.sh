#!/usr/bin/env bash
# Runs a small experiment under Slurm and compares its digest with that of a run on this machine. Needs the packages
# slurm-wlm and munge, and root: it sets up a cluster of this one node in a temporary folder, and takes it down again.
# `deploy/slurm/test.sh FOLDER-OF-PROGRAMS`, target/debug for example.
set -euo pipefail

programs=$(cd "$1" && pwd)
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
place=$(mktemp -d)
chmod 755 "$place"
export PATH=$programs:$PATH SLURM_CONF=$place/slurm.conf SELFTALK_DIR=$place/study

take_down() {
    scancel --full --user=root 2>/dev/null || true
    sleep 1
    # A daemon writes its last files when it is told to end: the folder can go when all have ended.
    local daemon pid
    for daemon in slurmd slurmctld munged; do
        pid=$(cat "$place/$daemon.pid" 2>/dev/null) || continue
        kill "$pid" 2>/dev/null || true
        for _ in $(seq 300); do
            kill -0 "$pid" 2>/dev/null || break
            sleep 0.1
        done
    done
    [[ -n ${KEEP:-} ]] || rm -rf "$place" || echo "$place is left behind" >&2
}
trap take_down EXIT

until_true() {
    for _ in $(seq 600); do
        if "$@"; then return; fi
        sleep 0.5
    done
    echo "waited in vain: $*" >&2
    tail -n 20 "$place"/*.log "$SELFTALK_DIR"/*.log >&2 || true
    exit 1
}

# The cluster.
mkdir -m 700 "$place/munge"
dd if=/dev/urandom of="$place/munge/key" bs=1024 count=1 status=none
chmod 600 "$place/munge/key"
munged --force --key-file="$place/munge/key" --socket="$place/munged.socket" --pid-file="$place/munged.pid" \
    --log-file="$place/munged.log" --seed-file="$place/munge/seed"
mkdir "$place/state" "$place/spool" "$SELFTALK_DIR"
cat >"$SLURM_CONF" <<END
ClusterName=selftalk
SlurmctldHost=$(hostname)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$place/munged.socket,cred_expire=5
StateSaveLocation=$place/state
SlurmdSpoolDir=$place/spool
SlurmctldPidFile=$place/slurmctld.pid
SlurmdPidFile=$place/slurmd.pid
SlurmctldLogFile=$place/slurmctld.log
SlurmdLogFile=$place/slurmd.log
SlurmctldPort=26817
SlurmdPort=26818
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
AccountingStorageType=accounting_storage/none
MpiDefault=none
ReturnToService=2
SchedulerParameters=sched_interval=2
NodeName=$(hostname) CPUs=16 RealMemory=4000 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES State=UP
END
slurmctld
slurmd
until_true sh -c "sinfo --noheader --format=%T | grep -q idle"

# The same experiment here, and there.
cat >"$SELFTALK_DIR/small.toml" <<END
name = "small"
replications = 3
generations = 80
evolution = { population = 20, parents = 4, mutation = 0.01 }
reach = { steps = 8 }
open = { steps = 8 }
grasp = { steps = 8 }
move = { steps = 8 }
END
cd "$SELFTALK_DIR"
selftalk run small.toml --db "$place/alone.db" --dashboard off 2>/dev/null
expected=$(selftalk digest small --db "$place/alone.db" --format csv)

generations() {
    selftalk history replications --db selftalk.db --format csv 2>/dev/null | awk -F, 'NR > 1 { sum += $4 } END { print sum + 0 }'
}
more_than() { (($(generations) > $1)); }
running() { [[ $(squeue --noheader --states=RUNNING --format=%i | wc -l) -ge $1 ]]; }
finished() { [[ -z $(squeue --noheader) ]]; }

master=$(sbatch --parsable --mem=100M "$here/master.sbatch" small.toml)
workers=$(sbatch --parsable --array=0-2 --cpus-per-task=1 --mem-per-cpu=100M "$here/workers.sbatch")
until_true running 4
until_true more_than 10
scancel "${workers}_1"
until_true more_than 40
scontrol requeue "$master"
until_true more_than 100
# As before the end of its time: it stops by itself, and comes back.
scancel --signal=TERM --batch "$master"
until_true finished
found=$(selftalk digest small --db selftalk.db --format csv)
grep -h "listening on" master-*.log
if [[ $found != "$expected" ]]; then
    printf 'the digests differ:\n%s\n%s\n' "$expected" "$found" >&2
    exit 1
fi
starts=$(ls master-*.log | wc -l)
echo "the same history under Slurm, with $starts starts of the master and a worker cancelled"
