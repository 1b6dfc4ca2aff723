// Checks of the machine for `godobject doctor` and `run --require-rt`: trial of the real-time set-up, clock
// and cores of the processor, throttling. Files: Linux's Documentation, folders admin-guide (cputopology,
// pm/cpufreq) and scheduler (sched-rt-group).
#include <algorithm>
#include <chrono>
#include <fstream>
#include <iterator>
#include <optional>
#include <system_error>
#include <thread>

#include "platform/rt/machine_files.h"

namespace godobject {
namespace {

namespace fs = std::filesystem;

// ---- real time --------------------------------------------------------------------------------------

/// Checks that the clock of each processor stays up. The governor powersave of most drivers is the lowest
/// frequency; that of drivers with "pstate" in their names follows the load.
RtStep check_governor(const fs::path& root) {
  RtStep step{.name = "governor", .result = RtResult::ok, .detail = "performance", .remedy = ""};
  const fs::path cpus = root / "sys/devices/system/cpu";
  std::error_code error;
  if (!fs::is_directory(cpus, error)) return unreadable(step.name, "/sys/devices/system/cpu");
  std::size_t num_policies = 0;
  for (const fs::directory_entry& policy : fs::directory_iterator(cpus / "cpufreq", error)) {
    const std::optional<std::string> governor = line_of(policy.path() / "scaling_governor");
    if (!governor) continue;
    ++num_policies;
    const std::string driver = line_of(policy.path() / "scaling_driver").value_or("");
    const bool lowest = *governor == "powersave" && driver.find("pstate") == std::string::npos;
    const RtResult result = *governor == "performance" ? RtResult::ok
                            : lowest                   ? RtResult::failed
                                                       : RtResult::degraded;
    if (result <= step.result) continue;
    step.result = result;
    step.detail =
        *governor + (lowest ? ": the lowest frequency at any load" : ": the clock rises after a delay");
    step.remedy = "cpupower frequency-set -g performance";
  }
  if (num_policies == 0) step.detail = "none: the kernel does not scale the frequency";
  return step;
}

/// Checks the share of a period that real-time threads may compute. A loop that reaches the kernel's default
/// of 95 % misses its deadlines without throttling.
RtStep check_throttling(const fs::path& root) {
  constexpr double default_share = 0.95;
  RtStep step{.name = "throttling", .result = RtResult::ok, .detail = "off", .remedy = ""};
  long runtime_us = 0, period_us = 0;
  if (!(std::ifstream(root / "proc/sys/kernel/sched_rt_runtime_us") >> runtime_us) ||
      !(std::ifstream(root / "proc/sys/kernel/sched_rt_period_us") >> period_us) || period_us <= 0)
    return unreadable(step.name, "/proc/sys/kernel/sched_rt_runtime_us");
  if (runtime_us < 0) return step;
  const double share = static_cast<double>(runtime_us) / static_cast<double>(period_us);
  step.detail = "real-time threads compute at most " + std::to_string(runtime_us / 1000) + " ms of each " +
                std::to_string(period_us / 1000) + " ms";
  if (share >= default_share) return step;
  step.result = runtime_us == 0 ? RtResult::failed : RtResult::degraded;
  step.remedy = "sysctl -w kernel.sched_rt_runtime_us=" +
                std::to_string(static_cast<long>(default_share * static_cast<double>(period_us)));
  return step;
}

// ---- cores ------------------------------------------------------------------------------------------

RtStep check_isolation(const fs::path& root) {
  RtStep step{.name = "isolated cores", .result = RtResult::ok, .detail = "", .remedy = ""};
  const std::optional<std::string> list = line_of(root / "sys/devices/system/cpu/isolated");
  if (!list) return unreadable(step.name, "/sys/devices/system/cpu/isolated");
  if (const Cores isolated = cores_in(*list); !isolated.empty()) {
    step.detail = list_of(isolated) + "; for the loop: run with --core " + std::to_string(*isolated.rbegin());
    return step;
  }
  step.result = RtResult::degraded;
  const Cores all = online_cores(root);
  if (all.size() < 2) {
    step.detail = "none, because there is one core: other programs delay the loop";
    step.remedy = "use a machine with two or more cores";
    return step;
  }
  step.detail = "none: other programs may delay the loop";
  step.remedy = boot_with(isolation_of(*all.rbegin(), all));
  return step;
}

}  // namespace

std::vector<RtStep> try_rt_thread(const MachineAccess& access, const RtThreadPlan& plan) {
  std::vector<RtStep> steps;
  try {
    std::thread([&] { steps = set_up_rt_thread(access, plan); }).join();
  } catch (const std::system_error& error) {
    steps.push_back({.name = "priority",
                     .result = RtResult::failed,
                     .detail = std::string("no thread can be started: ") + error.what(),
                     .remedy = "ulimit -u unlimited -v unlimited"});
  }
  // The kernel keeps the bandwidth of a thread of SCHED_DEADLINE to the end of its period.
  if (plan.runtime_ns > 0) std::this_thread::sleep_for(std::chrono::nanoseconds(2 * plan.period_ns));
  return steps;
}

std::vector<RtStep> real_time_checks(const MachineAccess& access, const RtThreadPlan& plan) {
  std::vector<RtStep> steps = RtProcess(access, plan).steps();
  std::ranges::move(try_rt_thread(access, plan), std::back_inserter(steps));
  steps.push_back(check_governor(access.root));
  steps.push_back(check_throttling(access.root));
  return steps;
}

std::vector<RtStep> core_checks(std::span<const std::string> interfaces, const MachineAccess& access) {
  return {check_isolation(access.root), check_interrupts(access.root, interfaces)};
}

std::string why_no_core(unsigned core, const MachineAccess& access) {
  const Cores all = online_cores(access.root);
  return all.contains(core) ? ""
                            : "this machine has no core " + std::to_string(core) + ": it has " + list_of(all);
}

}  // namespace godobject
