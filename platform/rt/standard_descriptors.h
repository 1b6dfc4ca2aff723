// Descriptors 0 to 2 of the process. A bus or file opened as one of them would receive the status lines.
#pragma once

namespace godobject {

/// Opens closed descriptors among 0 to 2 on /dev/null, so that later ones are above them. Call it before
/// anything else is opened. Returns false if /dev/null cannot be opened.
[[nodiscard]] bool keep_standard_descriptors() noexcept;

}  // namespace godobject
