#include "platform/rt/machine_files.h"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>
#include <system_error>

namespace godobject {

namespace fs = std::filesystem;

std::string error_text(int error) { return std::generic_category().message(error); }

std::optional<std::string> line_of(const fs::path& path) {
  std::ifstream file(path);
  if (!file) return std::nullopt;
  std::string line;
  std::getline(file, line);
  return line;
}

std::string text_after(const fs::path& path, std::string_view name) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);)
    if (line.starts_with(name)) return line.substr(name.size());
  return "";
}

std::uint64_t limit_of(const fs::path& root, std::string_view name) {
  std::istringstream columns(text_after(root / "proc/self/limits", name));
  std::string limit;
  columns >> limit;
  return limit == "unlimited" ? UINT64_MAX : std::strtoull(limit.c_str(), nullptr, 10);
}

bool has_capability(const fs::path& root, unsigned number) {
  std::istringstream mask(text_after(root / "proc/self/status", "CapEff:"));
  std::uint64_t bits = 0;
  return static_cast<bool>(mask >> std::hex >> bits) && (bits >> number & 1) != 0;
}

Cores cores_in(std::string_view list) {
  Cores cores;
  const char* at = list.data();
  const char* const end = at + list.size();
  const auto number = [&](unsigned& value) {
    const auto [next, error] = std::from_chars(at, end, value);
    at = next;
    return error == std::errc();
  };
  for (unsigned first = 0; number(first); ++at) {
    unsigned last = first;
    if (at != end && *at == '-' && (++at, !number(last))) break;
    for (unsigned core = first; core <= last; ++core) cores.insert(core);
    if (at == end || *at != ',') break;
  }
  return cores;
}

std::string list_of(const Cores& cores) {
  std::string text;
  for (const unsigned core : cores) text += (text.empty() ? "" : ",") + std::to_string(core);
  return text;
}

Cores without(const Cores& a, const Cores& b) {
  Cores rest;
  std::ranges::set_difference(a, b, std::inserter(rest, rest.end()));
  return rest;
}

Cores common(const Cores& a, const Cores& b) { return without(a, without(a, b)); }

Cores online_cores(const fs::path& root) {
  return cores_in(line_of(root / "sys/devices/system/cpu/online").value_or(""));
}

Cores isolated_cores(const fs::path& root) {
  return cores_in(line_of(root / "sys/devices/system/cpu/isolated").value_or(""));
}

std::string isolation_of(unsigned core, const Cores& online) {
  const std::string n = std::to_string(core);
  return "isolcpus=" + n + " nohz_full=" + n + " rcu_nocbs=" + n +
         " irqaffinity=" + list_of(without(online, {core}));
}

std::string raise_limit(const std::string& limit) {
  return "echo \"$USER - " + limit +
         "\" | sudo tee -a /etc/security/limits.d/godobject.conf, and log in again";
}

std::string boot_with(const std::string& options) {
  return "sed -i 's/^GRUB_CMDLINE_LINUX=\"/&" + options + " /' /etc/default/grub && update-grub && reboot";
}

RtStep unreadable(std::string name, const std::string& path) {
  return {.name = std::move(name),
          .result = RtResult::failed,
          .detail = "unknown, because " + path + " cannot be read",
          .remedy = path.starts_with("/proc") ? "mount -t proc proc /proc" : "mount -t sysfs sysfs /sys"};
}

}  // namespace godobject
