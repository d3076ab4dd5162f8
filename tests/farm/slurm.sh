#!/usr/bin/env bash
# Usage: slurm.sh FOLDER   Runs a Slurm cluster of one node on loopback until its standard input ends.
#
# Installs Slurm and munge from Debian's packages if they are absent, and starts munged, slurmctld and
# slurmd without systemd. Their files are in FOLDER, whose path has no spaces. Prints "ready" when jobs
# can run: with SLURM_CONF=FOLDER/slurm.conf. Ends with code 77 if this machine cannot run Slurm.
set -euo pipefail
folder=$(realpath "$1")
slots=6

skip() { echo "SKIPPED: $*" >&2; exit 77; }

[ "$(id -u)" = 0 ] || skip "Slurm's daemons need root"
if ! command -v slurmctld >/dev/null || ! command -v slurmd >/dev/null || ! command -v munged >/dev/null; then
  command -v apt-get >/dev/null || skip "Slurm is not installed, and there is no apt-get"
  { apt-get update -q && DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends slurm-wlm munge; } \
    >"$folder/install.log" 2>&1 || skip "apt-get could not install slurm-wlm and munge"
fi

host=$(hostname -s)
mkdir -p "$folder"/{munge,state,spool}
chmod 755 "$folder"
head -c 128 /dev/urandom >"$folder/munge/key"
chmod 400 "$folder/munge/key"
chmod 711 "$folder/munge"

# Ports differ between runs, so that two clusters of one machine do not meet.
port=$((20000 + $$ % 20000))
cat >"$folder/slurm.conf" <<END
ClusterName=loopback
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$port
SlurmdPort=$((port + 1))
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$folder/munge/socket
CryptoType=crypto/munge
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=batch_sched_delay=0,sched_interval=2
ReturnToService=2
MpiDefault=none
SwitchType=switch/none
KillWait=5
# The node claims $slots slots, whatever its number of processors.
SlurmdParameters=config_overrides
NodeName=$host NodeAddr=127.0.0.1 CPUs=$slots State=UNKNOWN
PartitionName=render Nodes=$host Default=YES State=UP
END
export SLURM_CONF=$folder/slurm.conf

daemons=()
stop() {
  # The script ends only daemons that it started.
  for pid in "${daemons[@]}"; do kill "$pid" 2>/dev/null || true; done
  wait 2>/dev/null || true
}
trap stop EXIT

munged --foreground --force --key-file="$folder/munge/key" --socket="$folder/munge/socket" --pid-file="$folder/munge/pid" \
  --log-file="$folder/munge/log" --seed-file="$folder/munge/seed" >"$folder/munged.log" 2>&1 </dev/null &
daemons+=($!)
for _ in $(seq 50); do [ -S "$folder/munge/socket" ] && break; sleep 0.1; done
slurmctld -D >"$folder/slurmctld.log" 2>&1 </dev/null &
daemons+=($!)
slurmd -D -N "$host" >"$folder/slurmd.log" 2>&1 </dev/null &
daemons+=($!)

for _ in $(seq 150); do
  if [ "$(sinfo --noheader --format %T 2>/dev/null)" = idle ]; then
    echo ready
    cat >/dev/null
    exit 0
  fi
  sleep 0.2
done
tail -n 20 "$folder"/*.log >&2
echo "the cluster did not start within 30 s" >&2
exit 1
