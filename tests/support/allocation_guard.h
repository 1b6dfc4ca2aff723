// Counts calls that a real-time loop must not make: heap, locks, sleeping, I/O, reading the clock.
#pragma once

#include <string>

namespace godobject {

/// Counts calls of the constructing thread during its lifetime. Functions named as libc's, linked into the
/// test program (allocation_guard.cc), do the counting; other libc functions are not counted. Not to be
/// nested.
///
///   AllocationGuard guard;
///   step(...);
///   EXPECT_EQ(guard.calls(), 0) << guard.report();
class AllocationGuard {
 public:
  AllocationGuard() noexcept;
  ~AllocationGuard();
  AllocationGuard(const AllocationGuard&) = delete;
  AllocationGuard& operator=(const AllocationGuard&) = delete;

  /// Stops counting, for functions that allocate themselves, such as report().
  void disarm() noexcept;
  /// Returns the counted calls of this thread since construction.
  long calls() const noexcept;
  /// Returns the allocator's calls only, for code that may read the clock and its own descriptors.
  long heap_calls() const noexcept;
  /// Returns name and number of each counted function that was called. Disarms.
  std::string report();

  /// Returns false if a sanitizer provides the libc functions: then nothing is counted.
  static bool works() noexcept;
};

}  // namespace godobject
