// Revision of the sources of this program.
#pragma once

#include <string_view>

namespace godobject {

/// Returns the commit of the sources in git, with a hash of uncommitted changes: "1a2b3c4d5e6f+7a8b9c0d".
/// "unknown" if they were built outside git. Each build defines it, see write_revision.cmake.
std::string_view revision() noexcept;

}  // namespace godobject
