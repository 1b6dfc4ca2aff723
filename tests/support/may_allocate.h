// Scope in which a test's part of a cycle may allocate and wait: a bus that it plays, an observer of frames.
#pragma once

#if defined(__has_feature)
#if __has_feature(realtime_sanitizer)
#include <sanitizer/rtsan_interface.h>
#endif
#endif

namespace godobject::test {

/// RealtimeSanitizer ends a program whose cycle allocates or waits, except in this scope.
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
