// Space for records on a disk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "platform/rt/setup.h"

namespace godobject {

/// Returns the bytes that this user may still write into a folder; none if there is no such folder.
std::optional<std::uint64_t> free_bytes(const std::filesystem::path& folder);
/// Checks that records can be written into a folder for an hour; less is degraded, below a minute failed.
/// free: bytes, see free_bytes(). bytes_per_s: bytes that a run writes, 1/s.
RtStep disk_check(const std::filesystem::path& folder, std::optional<std::uint64_t> free, double bytes_per_s);

}  // namespace godobject
