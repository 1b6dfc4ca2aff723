#!/bin/sh
# Builds state_hash_probe.cc with every compiler at hand, without optimisation and with all of it, with the flags of the
# `deterministic` preset: for x86-64-v1, for wider vectors, for x86-64-v3, and for aarch64, which runs in qemu-user. Demands that
# all print the same; otherwise names the first quantity that differs. With one compiler only: exit 77, not compared.
# Every compiler at every level, and 3000 steps, where GODOBJECT_NIGHTLY is set (./dev nightly); else 1000 steps of two builds, with
# different compilers, levels and widths, and those of the other processors.
#   compare.sh SOURCE_DIR EIGEN_INCLUDE_DIR WORK_DIR
set -eu
source_dir=$1 eigen=$2 work=$3
flags="-std=c++20 -DNDEBUG -DEIGEN_DONT_VECTORIZE -fno-math-errno -ffp-contract=off
  -fno-tree-vectorize -fno-tree-slp-vectorize"
# Forced inlining takes most of the time of a build, and is in the nightly ones.
[ -n "${GODOBJECT_NIGHTLY:-}" ] || flags="$flags -DGODOBJECT_NO_FLATTEN"
launcher=$(command -v ccache || true)
rm -rf "$work"
mkdir -p "$work"

# four numbers in one vector instead of two; and fused multiplication and addition, which -ffp-contract=off leaves out and g++ has
# from -O2 on
wide="" v3=""
if grep -qw avx2 /proc/cpuinfo 2> /dev/null; then wide=_-mavx2; fi
if grep -qw avx2 /proc/cpuinfo 2> /dev/null && grep -qw fma /proc/cpuinfo; then v3=_-march=x86-64-v3; fi
emulated=aarch64-linux-gnu-g++ emulated_steps=1000 # emulation is slow
steps=1000
[ -z "${GODOBJECT_NIGHTLY:-}" ] || steps=3000

levels_of() {
  if [ -n "${GODOBJECT_NIGHTLY:-}" ]; then
    echo -O0 -O3 ${wide:+-O3$wide} ${v3:+-O3$v3}
  elif [ "$1" = g++ ]; then
    echo "-O2$v3"
  else
    echo -O0
  fi
}

# build COMPILER LEVEL [LINK_OPTION]: the program $work/COMPILERLEVEL
build() {
  name=$work/$1$2
  # shellcheck disable=SC2046,SC2086
  $launcher "$1" $flags $(echo "$2" | tr _ ' ') -I "$source_dir" -isystem "$eigen" \
    -c "$source_dir/tests/determinism/state_hash_probe.cc" -o "$name.o"
  # shellcheck disable=SC2086
  "$1" "$name.o" ${3:-} -o "$name"
}

# run PROGRAM [ARGUMENT...]
run() {
  program=$1
  shift
  case $program in
    */"$emulated"*) qemu-aarch64 "$program" "$@" ;;
    *) "$program" "$@" ;;
  esac
}

# compare PROGRAM_A PROGRAM_B STEPS: their outputs PROGRAM.txt; names the first quantity that differs
compare() {
  if diff "$1.txt" "$2.txt"; then
    echo "$(basename "$2"): equal to $(basename "$1"), $3 steps"
    return
  fi
  echo "$(basename "$2"): other bits than $(basename "$1"); the first quantity that differs:"
  run "$1" "$3" each > "$1.each"
  run "$2" "$3" each > "$2.each"
  awk 'NR == FNR { of_a[FNR] = $0; next } of_a[FNR] != $0 { print "< " of_a[FNR]; print "> " $0; exit }' "$1.each" "$2.each"
  exit 1
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
for build in $builds; do
  build "${build%%/*}" "${build#*/}"
  run "$name" "$steps" > "$name.txt"
  [ -n "${reference:-}" ] || reference=$name
done

cat "$reference.txt"
grep -q ' [0-9a-f]\{16\}$' "$reference.txt"
if grep fault "$reference.txt"; then exit 1; fi
for build in $builds; do
  name=$work/${build%%/*}${build#*/}
  [ "$name" = "$reference" ] || compare "$reference" "$name" "$steps"
done

if command -v $emulated > /dev/null && command -v qemu-aarch64 > /dev/null; then
  build $emulated -O2 -static
  other=$name
  run "$reference" $emulated_steps > "$reference.txt"
  run "$other" $emulated_steps > "$other.txt"
  if grep fault "$other.txt"; then exit 1; fi
  compare "$reference" "$other" $emulated_steps
else
  echo "aarch64: left out; it needs $emulated (Debian g++-aarch64-linux-gnu) and qemu-aarch64 (qemu-user)"
fi
exit $incomplete
