#!/bin/sh
# Builds the quick tests of the core for aarch64 and runs them in qemu-user, every eighth case of each sweep. They are
# compiled by the project's own build description, with Debian's sources of googletest. Exit status 77: skipped, a package
# is missing.
#   core_tests.sh SOURCE_DIR WORK_DIR [OPTION OF GOOGLETEST...]
set -eu
source_dir=$1 work=$2
shift 2
toolchain=$source_dir/tests/aarch64/toolchain.cmake
googletest=/usr/src/googletest

missing=""
command -v aarch64-linux-gnu-g++ > /dev/null || missing="$missing g++-aarch64-linux-gnu"
command -v qemu-aarch64 > /dev/null || missing="$missing qemu-user"
[ -e $googletest/CMakeLists.txt ] || missing="$missing googletest"
if [ -n "$missing" ]; then
  echo "skipped: install$missing (./dev setup test)"
  exit 77
fi

# quietly NAME COMMAND...: prints the output, WORK_DIR/NAME.log, of a command that fails
quietly() {
  log=$work/$1.log
  shift
  "$@" > "$log" 2>&1 || { cat "$log"; exit 1; }
}
mkdir -p "$work"
quietly googletest cmake -S $googletest -B "$work/googletest" -G Ninja --toolchain "$toolchain" \
  -D CMAKE_BUILD_TYPE=Release -D CMAKE_CXX_STANDARD=17 -D CMAKE_INSTALL_PREFIX="$work/installed"
quietly googletest cmake --build "$work/googletest" --target install
quietly configure cmake -S "$source_dir" -B "$work/build" -G Ninja --toolchain "$toolchain" -D CMAKE_BUILD_TYPE=Release \
  -D GODOBJECT_MARCH= -D GODOBJECT_BENCH=OFF -D GTest_ROOT="$work/installed"
quietly build cmake --build "$work/build" --target test_core_quick
cd "$work/build"
GODOBJECT_SHARE=8 qemu-aarch64 -L /usr/aarch64-linux-gnu tests/test_core_quick --gtest_brief=1 "$@"
