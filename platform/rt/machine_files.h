// Files of /proc and /sys that describe this machine, for its set-up and its checks. Internal to this folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "platform/rt/setup.h"

namespace godobject {

/// Returns the text of an errno.
std::string error_text(int error);

/// Returns the first line of a file; none if it cannot be read.
std::optional<std::string> line_of(const std::filesystem::path& path);

/// Returns the text after `name` in /proc/self/limits or /proc/self/status; empty if there is none.
std::string text_after(const std::filesystem::path& path, std::string_view name);

/// Returns a limit of this process; UINT64_MAX: not limited, 0: unknown.
std::uint64_t limit_of(const std::filesystem::path& root, std::string_view name);

/// True if this process has the capability of this number (capabilities(7)), for which limits do not apply.
bool has_capability(const std::filesystem::path& root, unsigned number);

using Cores = std::set<unsigned>;

/// Reads the kernel's lists of processors: "0-2,5".
Cores cores_in(std::string_view list);
std::string list_of(const Cores& cores);
Cores without(const Cores& a, const Cores& b);
Cores common(const Cores& a, const Cores& b);
Cores online_cores(const std::filesystem::path& root);
Cores isolated_cores(const std::filesystem::path& root);

/// Returns the options of the kernel's command line that keep other programs and interrupts off a core.
std::string isolation_of(unsigned core, const Cores& online);

/// Returns the command that raises a limit of this user. limit: "memlock unlimited".
std::string raise_limit(const std::string& limit);
/// Returns the command that adds options to the kernel's command line and boots with them.
std::string boot_with(const std::string& options);

/// Takes the scheduling class and the cores of the plan for the calling thread.
std::vector<RtStep> take_scheduling(const MachineAccess& access, const RtThreadPlan& plan);
/// Moves all threads of this process away from the core, and later ones with them. Returns the number moved,
/// or the error of the system as a negative number.
int keep_off(unsigned core, const std::filesystem::path& root);

/// Returns the checks of interrupt threads. interfaces: see core_checks().
RtStep check_interrupts(const std::filesystem::path& root, std::span<const std::string> interfaces);
/// Returns a check that failed because a file or folder of /proc or /sys cannot be read.
RtStep unreadable(std::string name, const std::string& path);

}  // namespace godobject
