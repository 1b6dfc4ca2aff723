#include "platform/rt/disk.h"

#include <sys/statvfs.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <string>

namespace godobject {

std::optional<std::uint64_t> free_bytes(const std::filesystem::path& folder) {
  struct statvfs disk {};
  if (statvfs(folder.c_str(), &disk) != 0) return std::nullopt;
  return std::uint64_t{disk.f_bavail} * disk.f_frsize;
}

RtStep disk_check(const std::filesystem::path& folder, std::optional<std::uint64_t> free,
                  double bytes_per_s) {
  constexpr double hour = 3600, minute = 60;  // s
  RtStep step{.name = "disk", .result = RtResult::failed, .detail = "", .remedy = ""};
  const std::string name = folder.string();
  if (!free || eaccess(folder.c_str(), W_OK | X_OK) != 0) {
    step.detail = name + (free ? " cannot be written" : " is no folder");
    step.remedy = free ? "chown $USER " + name : "mkdir -p " + name;
    return step;
  }
  const double bytes = static_cast<double>(*free), seconds = bytes / bytes_per_s;
  std::array<char, 96> text{};
  std::snprintf(text.data(), text.size(), ": %.3g GB free, %.3g h of a trace of %.2g MB/s", 1e-9 * bytes,
                seconds / hour, 1e-6 * bytes_per_s);
  step.detail = name + text.data();
  step.result = seconds >= hour ? RtResult::ok : seconds >= minute ? RtResult::degraded : RtResult::failed;
  if (step.result != RtResult::ok)
    step.remedy =
        "delete old records (du -sh " + name + "/*), write to another disk, or run with --trace-every 10";
  return step;
}

}  // namespace godobject
