// Lengths of tests that `./dev nightly` makes longer.
#pragma once

#include <cstdlib>

#include "tests/support/allocation_guard.h"

namespace godobject::test {

/// Returns the second length in nightly runs of programs without a sanitizer, else the first.
template <class Length>
Length length_of(Length usual, Length nightly) {
  return std::getenv("GODOBJECT_NIGHTLY") && AllocationGuard::works() ? nightly : usual;
}

}  // namespace godobject::test
