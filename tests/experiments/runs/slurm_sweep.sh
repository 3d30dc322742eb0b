#!/usr/bin/env bash
# Run a sweep on a one-node SLURM of its own, as root on Debian or Ubuntu; ends with 0 if the jobs that can
# work have worked and the one that cannot is a line. Where the packages cannot be had, or a container does
# not let their daemons start, it prints that and ends with 0: only the sweep is tested.
#   bash tests/experiments/runs/slurm_sweep.sh [PYTHON]
set -euo pipefail
python=$(command -v "${1:-.venv/bin/python}")
python=$(cd "$(dirname "$python")" && pwd)/$(basename "$python")

if ! command -v slurmctld munged >/dev/null; then
    if [ "$(id -u)" != 0 ] || ! { apt-get update -q && DEBIAN_FRONTEND=noninteractive apt-get install -y -q \
        --no-install-recommends slurm-wlm munge; } >/dev/null 2>&1; then
        echo "slurm: skipped, slurm-wlm and munge are not installed and cannot be"
        exit 0
    fi
fi

folder=$(mktemp -d)
host=$(hostname -s)
end() {
    for name in slurmd slurmctld munged; do
        [ ! -s "$folder/$name.pid" ] || kill "$(cat "$folder/$name.pid")" 2>/dev/null || true
    done
    sleep 1
    rm -rf "$folder"
}
trap end EXIT

mkdir "$folder/state" "$folder/spool" "$folder/work"
chmod 755 "$folder"
head -c 1024 /dev/urandom >"$folder/munge.key"
chmod 400 "$folder/munge.key"
not_started() {
    tail -n 20 "$folder"/*.log >&2 || true
    echo "slurm: skipped, its daemons do not start on this machine"
    exit 0
}
munged --force --key-file="$folder/munge.key" --socket="$folder/munge.sock" --pid-file="$folder/munged.pid" \
    --log-file="$folder/munged.log" --seed-file="$folder/munge.seed" 2>/dev/null || not_started

cat >"$folder/slurm.conf" <<CONF
ClusterName=one
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
SlurmctldPort=16817
SlurmdPort=16818
AuthType=auth/munge
AuthInfo=socket=$folder/munge.sock
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
MpiDefault=none
ReturnToService=2
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) RealMemory=$(awk '/MemTotal/ {print int($2 / 1100)}' /proc/meminfo)
PartitionName=main Nodes=ALL Default=YES State=UP
CONF
export SLURM_CONF="$folder/slurm.conf"
slurmctld || not_started
slurmd || not_started
for _ in $(seq 120); do
    [ "$(sinfo -h -o %T 2>/dev/null)" != idle ] || break
    sleep 0.5
done
[ "$(sinfo -h -o %T)" = idle ] || not_started

cd "$folder/work"
sweep() {
    "$python" -m narx.experiments.train -m debug=tiny model.hidden=2,0,3 hydra.sweep.dir=sweep \
        hydra/launcher=submitit_slurm hydra.launcher.partition=main hydra.launcher.cpus_per_task=1 \
        hydra.launcher.mem_gb=2 hydra.launcher.timeout_min=20 2>&1 | tee said
}
expect() {
    "$@" || { echo "slurm: not so: $*" >&2; tail -n 40 "$folder"/slurm*.log sweep/.submitit/*/*.err >&2; exit 1; }
}
status=0
sweep || status=$?
expect [ "$status" = 2 ]
expect [ "$(ls sweep/*/checkpoint.pt | wc -l)" = 2 ]
expect [ "$(grep -c '^error: job 1 (model.hidden=0): model.hidden is ' said)" = 1 ]
sweep >/dev/null || true
expect [ "$(cat sweep/.submitit/*/*.out | grep -c 'already finished')" = 2 ]
echo "slurm: two jobs finished, one refused in a line; the same sweep again did nothing anew"
