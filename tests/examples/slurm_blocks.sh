#!/bin/bash
# slurm_blocks.sh BCC4 FOLDER TOP: imports a series in blocks of space as an array of a real Slurm, with a controller and one
# node on this machine, which are started here by a configuration of their own and ended again. A task that runs is killed and
# put back into the queue; a dependent job joins; the file has the bytes of one process. Exit 77 without Slurm, munge or root.
# Debian: apt-get install slurmctld slurmd slurm-client munge.
set -euo pipefail
bcc4=$(realpath "$1") folder=$2 top=$(realpath "$3")
for program in slurmctld slurmd sbatch munged; do
  PATH=$PATH:/usr/sbin command -v $program >/dev/null || { echo "SKIP: there is no $program"; exit 77; }
done
((EUID == 0)) || { echo "SKIP: slurmd is started by root only"; exit 77; }
export PATH=${bcc4%/*}:$PATH:/usr/sbin
rm -rf "$folder" && mkdir -p "$folder"/{state,spool,work} && chmod 755 "$folder" && folder=$(realpath "$folder")
export SLURM_CONF=$folder/slurm.conf
node=$(hostname -s) port=$((20000 + 2 * ($$ % 5000))) job="" started=()

stop() { # what was started here, the last one first; each ends by itself
  local i pid tries
  [[ ! ${holder:-} ]] || kill "$holder" 2>/dev/null || true
  [[ -z $job ]] || scancel "$job" 2>/dev/null || true
  for ((i = ${#started[@]} - 1; i >= 0; --i)); do
    pid=$(cat "${started[i]}" 2>/dev/null) || continue
    kill "$pid" 2>/dev/null || continue
    for ((tries = 0; tries < 100; ++tries)); do
      if [[ ! -e ${started[i]} ]] || ! kill -0 "$pid" 2>/dev/null; then break; fi
      sleep .1
    done
  done
}
trap stop EXIT
fail() {
  echo "slurm_blocks: $*" >&2
  tail -n 15 "$folder"/*.log "$folder"/work/*.out >&2 || true
  exit 1
}
wait_for() { # SECONDS COMMAND...: until the command succeeds
  local end=$((SECONDS + $1))
  until "${@:2}"; do
    ((SECONDS < end)) || fail "waited in vain for: ${*:2}"
    sleep .2
  done
}

cat >"$SLURM_CONF" <<CONF
ClusterName=blocks
SlurmctldHost=$node(127.0.0.1)
AuthType=auth/munge
AuthInfo=socket=$folder/munge.socket
CredType=cred/munge
SlurmUser=root
SlurmctldPort=$port
SlurmdPort=$((port + 1))
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
SlurmdParameters=config_overrides
MpiDefault=none
ReturnToService=2
KillWait=2
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
NodeName=$node NodeAddr=127.0.0.1 CPUs=2 RealMemory=2048
PartitionName=all Nodes=$node Default=YES State=UP
CONF
head -c 128 /dev/urandom >"$folder/munge.key" && chmod 600 "$folder/munge.key"
started+=("$folder/munge.pid")
munged --force --key-file="$folder/munge.key" --socket="$folder/munge.socket" --pid-file="$folder/munge.pid" \
  --log-file="$folder/munged.log" --seed-file="$folder/munge.seed"
started+=("$folder/slurmctld.pid") && slurmctld
started+=("$folder/slurmd.pid") && slurmd -N "$node"
is_idle() { sinfo -h -o %t 2>/dev/null | grep -q '^idle$'; }
wait_for 60 is_idle

# Noise in half of the box: no block is done at once, and a part of each is air.
cd "$folder/work"
python3 - <<'PY'
import random
n, frames, noise = 96, 40, random.Random(1)
with open('a.raw', 'wb') as f:
    for _ in range(frames):
        for z in range(n):
            f.write(b''.join(noise.randbytes(n // 2) + bytes(n // 2) for _ in range(n)))
PY
bcc4 import a.raw --dims 96,96,96,40 --dtype u8 --blocks --exact --lattice d4star --dry-run --plan plan.json >plan.txt
bcc4 import --plan plan.json -o one.bcc4 --quiet

blocks=6 killed=2
# Held, so that it is not done before Slurm has been asked to kill it: it takes half a second, and is looked for before it begins.
(until [[ -s smoke.part$killed.bcc4.partial ]] && pkill -STOP -f "^bcc4 import .* -o smoke\.part$killed\.bcc4\$"; do sleep .01; done) &
holder=$!
job=$(sbatch --parsable --requeue --cpus-per-task=1 --mem=512M --array=1-$blocks "$top/examples/import_array.sh" plan.json smoke)
join=$(sbatch --parsable --mem=512M --dependency="afterok:$job" --wrap 'bcc4 concat smoke.part*.bcc4 -o smoke.bcc4 --quiet')
is_held() { ! kill -0 "$holder" 2>/dev/null; }
wait_for 120 is_held
scontrol requeue "${job}_$killed"
[[ ! -e smoke.part$killed.bcc4 ]] || fail "task $killed was done before it was killed"
is_pending() { squeue -h -t PD -o %K -j "$job" -r | grep -qx $killed; }
wait_for 60 is_pending
echo "task $killed: killed and requeued, with $(stat -c %s "smoke.part$killed.bcc4.partial") bytes done"
scontrol update "JobId=${job}_$killed" StartTime=now # Slurm waits for two minutes
is_done() { [[ -z $(squeue -h -j "$job,$join" 2>/dev/null) ]]; }
wait_for 300 is_done
[[ $(scontrol show job "${job}_$killed" | grep -o 'Restarts=[0-9]*') == Restarts=1 ]] || fail "task $killed was not restarted"
cmp smoke.bcc4 one.bcc4 || fail "the joined file differs"
echo "slurm_blocks: $blocks tasks of job $job, joined by job $join: the $(stat -c %s one.bcc4) bytes of one process"
