#!/bin/sh
# Builds state_hash_probe.cc with every compiler at hand, without optimisation and with all of it, with the flags of the
# `deterministic` preset and for wider vectors, and demands that all print the same. With one compiler only: exit 77, not compared.
# Every compiler at every level where GODOBJECT_EVERY_LEVEL is set (./dev nightly); else two builds, with different compilers,
# levels and widths (docs/decisions/041).
#   compare.sh SOURCE_DIR EIGEN_INCLUDE_DIR WORK_DIR
set -eu
source_dir=$1 eigen=$2 work=$3
flags="-std=c++20 -DNDEBUG -DEIGEN_DONT_VECTORIZE -fno-math-errno -ffp-contract=off
  -fno-tree-vectorize -fno-tree-slp-vectorize"
# Forced inlining takes most of the time of a build, and is in the nightly ones.
[ -n "${GODOBJECT_EVERY_LEVEL:-}" ] || flags="$flags -DGODOBJECT_NO_FLATTEN"
launcher=$(command -v ccache || true)
rm -rf "$work"
mkdir -p "$work"

# four numbers in one vector instead of two
wide=""
if grep -qw avx2 /proc/cpuinfo 2> /dev/null; then wide=_-mavx2; fi

levels_of() {
  if [ -n "${GODOBJECT_EVERY_LEVEL:-}" ]; then
    echo -O0 -O3 ${wide:+-O3$wide}
  elif [ "$1" = g++ ]; then
    echo -O3
  else
    echo "-O0$wide"
  fi
}

# run COMPILER/LEVEL...: one after the other, each leaving its output in a file of its own.
run() {
  for build in "$@"; do
    compiler=${build%%/*} level=${build#*/}
    name=$work/$compiler$level
    # shellcheck disable=SC2046,SC2086
    $launcher "$compiler" $flags $(echo "$level" | tr _ ' ') -I "$source_dir" -isystem "$eigen" \
      -c "$source_dir/tests/determinism/state_hash_probe.cc" -o "$name.o"
    "$compiler" "$name.o" -o "$name"
    "$name" > "$name.txt"
  done
}

builds="" incomplete=0
for compiler in g++ clang++; do
  if ! command -v "$compiler" > /dev/null; then
    echo "$compiler: not on this machine, left out"
    incomplete=77
    continue
  fi
  for level in $(levels_of "$compiler"); do builds="$builds $compiler/$level"; done
done
# shellcheck disable=SC2086
run $builds

reference=$(ls "$work"/*.txt | head -n 1)
cat "$reference"
grep -q ' [0-9a-f]\{16\}$' "$reference"
if grep fault "$reference"; then exit 1; fi
for output in "$work"/*.txt; do
  if ! diff "$reference" "$output"; then
    echo "$(basename "$output" .txt): other bits than $(basename "$reference" .txt)"
    exit 1
  fi
  echo "$(basename "$output" .txt): equal"
done
exit $incomplete
