#!/bin/bash
# One task of a Slurm array that imports a series together:
#
#   bcc4 import 'smoke.*.vdb' --dry-run --plan plan.json
#   job=$(sbatch --parsable --array=1-8 examples/import_array.sh plan.json smoke)
#   sbatch --dependency=afterok:$job --wrap 'bcc4 concat smoke.part*.bcc4 -o smoke.bcc4'
#
# The same on one machine: parallel -j2 bcc4 import --plan plan.json --part {}/8 --quiet -o smoke.part{}.bcc4 ::: {1..8}
#
# Frames that are larger than a node: with --blocks in the first line each task imports a box of all frames.
#
# A task that is requeued goes on where it was stopped (tests/examples/slurm_blocks.sh). Cores and memory are those of the allocation.
#SBATCH --job-name=bcc4-import
#SBATCH --cpus-per-task=2
#SBATCH --mem=4G
set -euo pipefail
plan=${1:?usage: import_array.sh PLAN.json NAME} name=${2:?usage: import_array.sh PLAN.json NAME}
part=$name.part$SLURM_ARRAY_TASK_ID.bcc4
if [[ -e $part ]]; then exit 0; fi
limits=(--threads "${SLURM_CPUS_PER_TASK:-1}")
if [[ -n ${SLURM_MEM_PER_NODE:-} ]]; then # MiB; an eighth for the program itself
  limits+=(--max-mem "$((SLURM_MEM_PER_NODE * 7 / 8))M")
fi
exec bcc4 import --plan "$plan" --part "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT" --resume --quiet "${limits[@]}" -o "$part"
