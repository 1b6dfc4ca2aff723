#!/bin/sh
# Runs the shards of the stability map with GNU parallel on all processors, and merges them. Shards of an earlier run
# that was killed are continued. For several machines put parallel's options into PARALLEL, e.g. --sshloginfile; they need
# the same folder.
#   parallel.sh PROGRAM DIR SHARDS [SEED [SAMPLES]]
# PROGRAM: godobject-stability-map or godobject-study
set -eu
if [ $# -lt 3 ]; then
  echo "usage: parallel.sh PROGRAM DIR SHARDS [SEED [SAMPLES]]" >&2
  exit 2
fi
program=$1 directory=$2 shards=$3 seed=${4:-1} samples=${5:-1000000}
mkdir -p "$directory"
seq "$shards" | parallel --will-cite --line-buffer --retries 2 --joblog "$directory/jobs.log" \
  "$program" stability-map --seed "$seed" --samples "$samples" --shard "{}/$shards" --out "$directory/shard-{}.csv"
# in the order of the shards, so that the names in messages are
set --
for k in $(seq "$shards"); do set -- "$@" "$directory/shard-$k.csv"; done
"$program" stability-map --merge "$@" --out "$directory/stability-map.csv"
