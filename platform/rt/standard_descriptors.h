// Descriptors 0 to 2 of the process: a bus or a file that is opened as one of them receives the status lines.
#pragma once

namespace godobject {

/// Opens each of the descriptors 0 to 2 that is closed on /dev/null, so that every later one is above them. Before anything
/// else is opened. False if /dev/null cannot be opened.
[[nodiscard]] bool keep_standard_descriptors() noexcept;

}  // namespace godobject
