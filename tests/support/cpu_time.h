// Processor time of this process: a bound on it holds on a busy machine too.
#pragma once

#include <ctime>

namespace godobject::test {

/// Returns the processor time that this process has used, s.
inline double cpu_time_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

}  // namespace godobject::test
