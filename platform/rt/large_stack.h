// A stack of the usual size for a process that was given a smaller one (`ulimit -s`).
#pragma once

#include <functional>

namespace godobject {

/// Calls f in this thread, on a stack of 8 MB where the limit of the process's own is below that; threads that are started
/// meanwhile get as much. False, and f is not called, where there is no memory for it.
[[nodiscard]] bool call_on_large_stack(const std::function<void()>& f);

}  // namespace godobject
