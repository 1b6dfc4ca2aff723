// Files of the shared folder beside the checkout, which may be missing.
#pragma once

#include <cstdlib>
#include <filesystem>

namespace godobject::test {

/// Returns the path of `name` below GODOBJECT_SHARED or ../shared; empty if missing.
inline std::filesystem::path shared_file(const std::filesystem::path& name) {
  const char* const from_environment = std::getenv("GODOBJECT_SHARED");
  const std::filesystem::path folder =
      from_environment != nullptr ? from_environment : GODOBJECT_SOURCE_DIR "/../shared";
  return std::filesystem::exists(folder / name) ? folder / name : std::filesystem::path();
}

}  // namespace godobject::test
