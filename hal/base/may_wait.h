// Scope of a real-time cycle in which calls may wait: what stands for hardware, whose time stands still meanwhile.
#pragma once

#if defined(__has_feature)
#if __has_feature(realtime_sanitizer)
#include <sanitizer/rtsan_interface.h>
#define GODOBJECT_REALTIME_SANITIZER
#endif
#endif

namespace godobject {

/// RealtimeSanitizer reports no call of this thread while one exists.
class MayWait {
 public:
  MayWait(const MayWait&) = delete;
  MayWait& operator=(const MayWait&) = delete;
#ifdef GODOBJECT_REALTIME_SANITIZER
  MayWait() noexcept { __rtsan_disable(); }
  ~MayWait() { __rtsan_enable(); }
#else
  MayWait() noexcept {}
  ~MayWait() {}
#endif
};

}  // namespace godobject
