// Counts what a real-time loop must not do: heap, locks, sleeping, I/O, reading the clock.
#pragma once

#include <string>

namespace godobject {

/// Arms the calling thread's counters while it lives. Works by functions of the same names as libc's, linked
/// into the test program (allocation_guard.cc); nothing else of libc is watched. Not to be nested.
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

  /// Stops counting; asked for by what itself allocates, like report().
  void disarm() noexcept;
  /// Watched calls of this thread since construction.
  long calls() const noexcept;
  /// Of these, the allocator's: for what may read the clock and its own descriptors.
  long heap_calls() const noexcept;
  /// Name and number of each watched function that was called. Disarms.
  std::string report();

  /// False where the program's libc functions belong to a sanitizer: then nothing is counted.
  static bool works() noexcept;
};

}  // namespace godobject
