// Scope in which a bus that a test plays may allocate, within the cycle that calls it.
#pragma once

#if defined(__has_feature)
#if __has_feature(realtime_sanitizer)
#include <sanitizer/rtsan_interface.h>
#endif
#endif

namespace godobject::test {

/// RealtimeSanitizer ends a program whose cycle allocates, except in this scope.
class MayAllocate {
 public:
#if defined(__has_feature)
#if __has_feature(realtime_sanitizer)
  MayAllocate() { __rtsan_disable(); }
  ~MayAllocate() { __rtsan_enable(); }
  MayAllocate(const MayAllocate&) = delete;
  MayAllocate& operator=(const MayAllocate&) = delete;
#endif
#endif
};

}  // namespace godobject::test
