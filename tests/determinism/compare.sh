#!/bin/sh
# Builds state_hash_probe.cc with every compiler at hand, without optimisation and with all of it, with the flags of the
# `deterministic` preset and for wider vectors, and demands that all print the same. With one compiler only: exit 77, not compared.
# Every compiler at every level where GODOBJECT_EVERY_LEVEL is set (./dev nightly); else three builds that have each compiler,
# level and width once or twice (docs/decisions/041). Each integrator is a build of its own, two at a time.
#   compare.sh SOURCE_DIR EIGEN_INCLUDE_DIR WORK_DIR
#   compare.sh SOURCE_DIR EIGEN_INCLUDE_DIR WORK_DIR INTEGRATOR COMPILER LEVEL    builds and runs one
set -eu
source_dir=$1 eigen=$2 work=$3
flags="-std=c++20 -DNDEBUG -DEIGEN_DONT_VECTORIZE -fno-math-errno -ffp-contract=off
  -fno-tree-vectorize -fno-tree-slp-vectorize"

if [ $# -eq 6 ]; then
  integrator=$4 compiler=$5 level=$6
  name=$work/$integrator/$compiler$level
  # shellcheck disable=SC2046,SC2086
  $(command -v ccache || true) "$compiler" $flags $(echo "$level" | tr _ ' ') "-DPROBED_INTEGRATOR=$integrator" \
    -I "$source_dir" -isystem "$eigen" -c "$source_dir/tests/determinism/state_hash_probe.cc" -o "$name.o"
  "$compiler" "$name.o" -o "$name"
  "$name" > "$name.txt"
  exit
fi

rm -rf "$work"

# four numbers in one vector instead of two
wide=""
if grep -qw avx2 /proc/cpuinfo 2> /dev/null; then wide="-O3_-mavx2"; fi

levels_of() {
  if [ -n "${GODOBJECT_EVERY_LEVEL:-}" ]; then
    echo -O3 $wide -O0
  elif [ "$1" = g++ ]; then
    echo -O3 -O0
  else
    echo "${wide:--O3}"
  fi
}

# The longest first.
builds=""
incomplete=0
for compiler in g++ clang++; do
  if ! command -v "$compiler" > /dev/null; then
    echo "$compiler: not on this machine, left out"
    incomplete=77
    continue
  fi
  for level in $(levels_of "$compiler"); do
    for integrator in TrBdf2 ImplicitEuler; do
      mkdir -p "$work/$integrator"
      builds="$builds $integrator $compiler $level"
    done
  done
done
# shellcheck disable=SC2086
printf '%s\n' $builds | xargs -n 3 -P 2 sh "$0" "$source_dir" "$eigen" "$work"

for integrator in ImplicitEuler TrBdf2; do
  reference=$(ls "$work/$integrator"/*-O0.txt | head -n 1)
  cat "$reference"
  grep -q ' [0-9a-f]\{16\}$' "$reference"
  if grep fault "$reference"; then exit 1; fi
  for output in "$work/$integrator"/*.txt; do
    if ! diff "$reference" "$output"; then
      echo "$integrator, $(basename "$output" .txt): other bits than $(basename "$reference" .txt)"
      exit 1
    fi
    echo "$integrator, $(basename "$output" .txt): equal"
  done
done
exit $incomplete
