// Checks of the machine for `godobject doctor` and `run --require-rt`: trial of the real-time set-up, clock
// and cores of the processor, throttling, and interrupt threads. Files: Linux's Documentation, folders
// admin-guide (cputopology, pm/cpufreq), scheduler (sched-rt-group) and core-api (irq).
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <optional>
#include <set>
#include <sstream>
#include <system_error>
#include <thread>

#include "platform/rt/setup.h"

namespace godobject {
namespace {

namespace fs = std::filesystem;

using Cores = std::set<unsigned>;

/// Returns the first line of a file; none if it cannot be read.
std::optional<std::string> line_of(const fs::path& path) {
  std::ifstream file(path);
  if (!file) return std::nullopt;
  std::string line;
  std::getline(file, line);
  return line;
}

/// Reads the kernel's lists of processors: "0-2,5".
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

std::string text_of(const Cores& cores) {
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

Cores online(const fs::path& root) {
  return cores_in(line_of(root / "sys/devices/system/cpu/online").value_or(""));
}

/// path: of a file or folder of /proc or /sys.
RtStep unreadable(std::string name, const std::string& path) {
  return {.name = std::move(name),
          .result = RtResult::failed,
          .detail = "unknown, because " + path + " cannot be read",
          .remedy = path.starts_with("/proc") ? "mount -t proc proc /proc" : "mount -t sysfs sysfs /sys"};
}

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

/// Sets up a thread that ends at once.
std::vector<RtStep> try_rt_thread(const MachineAccess& access) {
  std::vector<RtStep> steps;
  try {
    std::thread([&] { steps = set_up_rt_thread(access); }).join();
  } catch (const std::system_error& error) {
    steps.push_back({.name = "priority",
                     .result = RtResult::failed,
                     .detail = std::string("no thread can be started: ") + error.what(),
                     .remedy = "raise the limits of processes and memory (ulimit -u, ulimit -v)"});
  }
  return steps;
}

// ---- cores and interrupts ---------------------------------------------------------------------------

RtStep check_isolation(const fs::path& root) {
  RtStep step{.name = "isolated cores", .result = RtResult::ok, .detail = "", .remedy = ""};
  const std::optional<std::string> list = line_of(root / "sys/devices/system/cpu/isolated");
  if (!list) return unreadable(step.name, "/sys/devices/system/cpu/isolated");
  if (const Cores isolated = cores_in(*list); !isolated.empty()) {
    step.detail = text_of(isolated) + "; the thread 'loop' must be moved there (docs/how-to/deploy.md)";
    return step;
  }
  step.result = RtResult::degraded;
  const Cores all = online(root);
  if (all.size() < 2) {
    step.detail = "none, because there is one core: other programs delay the loop";
    step.remedy = "use a machine with two or more cores";
    return step;
  }
  const std::string last = std::to_string(*all.rbegin());
  step.detail = "none: other programs may delay the loop";
  step.remedy = "boot with isolcpus=" + last + " nohz_full=" + last + " rcu_nocbs=" + last +
                " irqaffinity=" + text_of(without(all, {*all.rbegin()}));
  return step;
}

struct Interrupt {
  unsigned number = 0;
  std::vector<std::string> devices;  // names of its handlers
  Cores cores;                       // that may run it
  int thread = 0;                    // process id of its thread; 0: none
  int priority = 0;                  // of the thread; 0: not real-time
};

/// Returns the real-time priority of a process, the 40th column of its file `stat` (proc(5)).
int priority_of(const fs::path& process) {
  std::string text = line_of(process / "stat").value_or("");
  text.erase(0, text.rfind(')') + 1);  // the name before it may contain spaces
  std::istringstream columns(text);
  std::string column;
  for (int i = 3; i <= 39; ++i) columns >> column;
  int priority = 0;
  columns >> priority;
  return priority;
}

void find_threads(const fs::path& proc, std::vector<Interrupt>& interrupts) {
  std::error_code ignored;
  for (const fs::directory_entry& process : fs::directory_iterator(proc, ignored)) {
    const std::string id = process.path().filename();
    if (id.find_first_not_of("0123456789") != std::string::npos) continue;
    const std::string name = line_of(process.path() / "comm").value_or("");
    unsigned number = 0;
    if (std::sscanf(name.c_str(), "irq/%u-", &number) != 1) continue;
    const auto found = std::ranges::find(interrupts, number, &Interrupt::number);
    if (found == interrupts.end()) continue;
    found->thread = std::stoi(id);
    found->priority = priority_of(process.path());
  }
}

/// Returns the interrupts that have a handler, by number.
std::vector<Interrupt> interrupts_of(const fs::path& root) {
  std::vector<Interrupt> interrupts;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(root / "proc/irq", ignored)) {
    const std::string name = entry.path().filename();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    Interrupt irq{.number = static_cast<unsigned>(std::stoul(name)), .devices = {}, .cores = {}};
    for (const fs::directory_entry& handler : fs::directory_iterator(entry.path(), ignored))
      if (handler.is_directory(ignored)) irq.devices.push_back(handler.path().filename());
    std::string cores = line_of(entry.path() / "effective_affinity_list").value_or("");
    if (cores.empty()) cores = line_of(entry.path() / "smp_affinity_list").value_or("");
    irq.cores = cores_in(cores);
    if (!irq.devices.empty()) interrupts.push_back(std::move(irq));
  }
  std::ranges::sort(interrupts, {}, &Interrupt::number);
  find_threads(root / "proc", interrupts);
  return interrupts;
}

std::string name_of(const Interrupt& irq) { return std::to_string(irq.number) + "-" + irq.devices.front(); }

/// Lists the first threads with their priorities and cores.
std::string threads_text(const std::vector<Interrupt>& interrupts) {
  constexpr std::size_t max_listed = 6;
  std::string text;
  std::size_t count = 0;
  for (const Interrupt& irq : interrupts) {
    if (irq.thread == 0 || ++count > max_listed) continue;
    text += (text.empty() ? "irq/" : ", irq/") + name_of(irq) + " (priority " + std::to_string(irq.priority) +
            ", core " + text_of(irq.cores) + ")";
  }
  if (count > max_listed) text += " and " + std::to_string(count - max_listed) + " more";
  return text.empty() ? "no interrupt has a thread" : text;
}

RtStep check_interrupts(const fs::path& root, std::span<const std::string> interfaces) {
  RtStep step{.name = "interrupts", .result = RtResult::degraded, .detail = "", .remedy = ""};
  std::error_code error;
  if (!fs::is_directory(root / "proc/irq", error)) return unreadable(step.name, "/proc/irq");
  const std::vector<Interrupt> interrupts = interrupts_of(root);
  const Cores isolated = cores_in(line_of(root / "sys/devices/system/cpu/isolated").value_or(""));
  const auto is_above_loop = [](const Interrupt& irq) { return irq.priority > rt_priority; };
  for (const Interrupt& irq : interrupts) {
    const bool is_of_bus = std::ranges::any_of(
        interfaces, [&](const std::string& name) { return std::ranges::count(irq.devices, name) > 0; });
    if (!is_of_bus || irq.thread == 0 || is_above_loop(irq)) continue;
    step.detail = "irq/" + name_of(irq) + " has priority " + std::to_string(irq.priority) +
                  ", below the loop's " + std::to_string(rt_priority) + ": frames wait for the loop";
    step.remedy = "chrt -f -p " + std::to_string(rt_priority + 5) + " " + std::to_string(irq.thread);
    return step;
  }
  for (const Interrupt& irq : interrupts) {
    if (common(irq.cores, isolated).empty() || is_above_loop(irq)) continue;
    step.detail =
        "interrupt " + name_of(irq) + " may run on the isolated core " + text_of(common(irq.cores, isolated));
    step.remedy = "echo " + text_of(without(online(root), isolated)) + " > /proc/irq/" +
                  std::to_string(irq.number) + "/smp_affinity_list";
    return step;
  }
  step.detail = threads_text(interrupts);
  const bool have_threads =
      has_preempt_rt(root) ||
      line_of(root / "proc/cmdline").value_or("").find("threadirqs") != std::string::npos;
  step.result = have_threads ? RtResult::ok : RtResult::degraded;
  if (!have_threads) {
    step.detail = "most handlers are not threads, and delay the loop: " + step.detail;
    step.remedy = "boot with threadirqs, or a kernel with PREEMPT_RT";
  }
  return step;
}

}  // namespace

std::vector<RtStep> real_time_checks(const MachineAccess& access) {
  std::vector<RtStep> steps = RtProcess(access).steps();
  std::ranges::move(try_rt_thread(access), std::back_inserter(steps));
  steps.push_back(check_governor(access.root));
  steps.push_back(check_throttling(access.root));
  return steps;
}

std::vector<RtStep> core_checks(std::span<const std::string> interfaces, const MachineAccess& access) {
  return {check_isolation(access.root), check_interrupts(access.root, interfaces)};
}

}  // namespace godobject
