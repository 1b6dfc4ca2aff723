// A stack of the usual size for a process with a smaller limit (`ulimit -s`).
#pragma once

#include <functional>

namespace godobject {

/// Calls f in this thread, on a stack of 8 MB if the process's limit is lower; threads that start meanwhile
/// get as much. Returns false, without calling f, if out of memory.
[[nodiscard]] bool call_on_large_stack(const std::function<void()>& f);

}  // namespace godobject
