#!/bin/sh
#SBATCH --job-name=stability-map
#SBATCH --ntasks=1
#SBATCH --time=12:00:00
#SBATCH --requeue
#SBATCH --open-mode=append
# Runs one shard of the stability map in each task of a Slurm array. A task that was killed continues its file when it
# is submitted again; give SHARDS then, because the array is smaller.
#   sbatch --array=1-64 slurm.sh PROGRAM DIR [SEED [SAMPLES]]
#   SHARDS=64 sbatch --array=3,17 slurm.sh PROGRAM DIR [SEED [SAMPLES]]
#   PROGRAM stability-map --merge DIR/shard-*.csv --out DIR/stability-map.csv
# PROGRAM: godobject-stability-map or godobject-study
set -eu
if [ $# -lt 2 ]; then
  echo "usage: sbatch --array=1-N slurm.sh PROGRAM DIR [SEED [SAMPLES]]" >&2
  exit 2
fi
program=$1 directory=$2 seed=${3:-1} samples=${4:-1000000}
if [ -z "${SLURM_ARRAY_TASK_ID:-}" ]; then
  echo "slurm.sh: SLURM_ARRAY_TASK_ID is not set; submit it as an array, sbatch --array=1-N" >&2
  exit 2
fi
shards=${SHARDS:-${SLURM_ARRAY_TASK_COUNT:?the number of shards; set SHARDS}}
mkdir -p "$directory"
exec "$program" stability-map --seed "$seed" --samples "$samples" --shard "$SLURM_ARRAY_TASK_ID/$shards" \
  --out "$directory/shard-$SLURM_ARRAY_TASK_ID.csv"
