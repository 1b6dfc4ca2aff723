// Files of the shared folder next to the checkout, which a test may find or not.
#pragma once

#include <cstdlib>
#include <filesystem>

namespace godobject::test {

/// Path of `name` below GODOBJECT_SHARED or ../shared; empty when it is not there.
inline std::filesystem::path shared_file(const std::filesystem::path& name) {
  const char* const from_environment = std::getenv("GODOBJECT_SHARED");
  const std::filesystem::path folder =
      from_environment != nullptr ? from_environment : GODOBJECT_SOURCE_DIR "/../shared";
  return std::filesystem::exists(folder / name) ? folder / name : std::filesystem::path();
}

}  // namespace godobject::test
