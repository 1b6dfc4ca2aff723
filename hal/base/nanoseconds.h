// Time of buses, devices and loops.
#pragma once

#include <cmath>
#include <cstdint>

namespace godobject {

using Nanoseconds = std::int64_t;  // since an arbitrary origin of the clock in use; never wall-clock time
inline Nanoseconds to_ns(double seconds) noexcept { return std::llround(1e9 * seconds); }

}  // namespace godobject
