// Set-up of the process: standard descriptors, stack, and real time under Linux, step by step. Each step has
// a result, so that no failure is silent. Also the machine's properties, for reports.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/base/nanoseconds.h"

namespace godobject {

enum class RtResult : std::uint8_t {
  ok,
  degraded,  // works, with longer latencies than possible
  failed,
};
std::string_view name_of(RtResult result) noexcept;

struct RtStep {
  std::string name;
  RtResult result = RtResult::ok;
  std::string detail;  // the setting in effect, or the system's error text
  std::string remedy;  // empty if ok
};

/// Access to the machine. Tests replace the folder and the system calls.
struct MachineAccess {
  std::filesystem::path root = "/";             // folder of /proc, /sys and /dev
  std::function<int(int flags)> lock_memory{};  // returns 0 or errno; empty: mlockall
  // of this thread; each returns 0 or errno
  std::function<int(int priority)> take_priority{};                             // empty: SCHED_FIFO
  std::function<int(Nanoseconds runtime, Nanoseconds period)> take_deadline{};  // empty: SCHED_DEADLINE
  std::function<int(unsigned core)> take_core{};                                // empty: sched_setaffinity
};

/// Choices for the loop's thread. It may not have both, because SCHED_DEADLINE needs all cores of its group.
struct RtThreadPlan {
  std::optional<unsigned> core{};  // core of this thread alone; none: any core
  // of SCHED_DEADLINE in each period; 0: SCHED_FIFO. The period is then that of the loop.
  Nanoseconds runtime_ns = 0, period_ns = 0;
};
/// Names of the steps that a plan demands.
inline constexpr const char *core_step = "core", *deadline_step = "deadline";

/// Setup of the process, undone by the destructor. Not for the loop.
class RtProcess {
 public:
  /// Checks the kernel's preemption, locks memory and keeps it, forbids deep sleep states of the processor.
  /// Moves all threads off the core of the plan, if any, for good; the loop's thread can still go there.
  explicit RtProcess(const MachineAccess& access = {}, const RtThreadPlan& plan = {});
  ~RtProcess();
  RtProcess(const RtProcess&) = delete;
  RtProcess& operator=(const RtProcess&) = delete;

  const std::vector<RtStep>& steps() const noexcept { return steps_; }

 private:
  RtStep forbid_deep_sleep(const std::filesystem::path& root);

  std::vector<RtStep> steps_;
  int latency_fd_ = -1;  // the request is in effect while it is open
};

/// Sets up the calling thread: core and scheduling of the plan, by default SCHED_FIFO at rt_priority or the
/// highest permitted one, stack touched.
std::vector<RtStep> set_up_rt_thread(const MachineAccess& access = {}, const RtThreadPlan& plan = {});

/// Above the interrupt threads' 50, below the kernel's own 99.
inline constexpr int rt_priority = 80;

/// Formats one line a step: name, result, detail, remedy.
std::string rt_table(std::span<const RtStep> steps);

/// True for a kernel with PREEMPT_RT, which has threads for interrupts.
bool has_preempt_rt(const std::filesystem::path& root);

// Checks of the machine, see platform/rt/machine_checks.cc. They change no setting of the
// machine.

/// Returns the requirements of real time: the set-up of a run, tried out, frequency scaling and throttling.
std::vector<RtStep> real_time_checks(const MachineAccess& access = {}, const RtThreadPlan& plan = {});
/// Returns the set-up of the loop's thread, tried out in a thread that ends at once.
std::vector<RtStep> try_rt_thread(const MachineAccess& access = {}, const RtThreadPlan& plan = {});
/// Returns why this machine has no such core; empty if it has.
std::string why_no_core(unsigned core, const MachineAccess& access = {});
/// Returns the checks of isolated cores and of interrupt threads.
/// interfaces: those whose interrupt threads must be above the loop.
std::vector<RtStep> core_checks(std::span<const std::string> interfaces, const MachineAccess& access = {});
/// Opens closed descriptors among 0 to 2 on /dev/null, so that later ones are above them. A bus or file
/// opened as one of them would receive the status lines. Call it before anything else is opened. Returns
/// false if /dev/null cannot be opened.
[[nodiscard]] bool keep_standard_descriptors() noexcept;

/// Calls f in this thread, on a stack of 8 MB of its own if the process's limit (`ulimit -s`) is lower or
/// its addresses are limited (`ulimit -v`). If lower, threads that start meanwhile get as much. Returns
/// false, without calling f, if out of memory.
[[nodiscard]] bool call_on_large_stack(const std::function<void()>& f);

/// Processor and kernel of this machine.
struct Machine {
  std::string cpu;  // model name
  unsigned num_cpus = 0;
  std::string kernel;  // release and version
};

Machine this_machine();

}  // namespace godobject
