// Set-up of the process: standard descriptors, stack, and real time under Linux, step by step. Each step has
// a result, so that no failure is silent. Also the machine's properties, for reports.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

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

/// Setup of the process, undone by the destructor. Not for the loop.
class RtProcess {
 public:
  /// Checks the kernel's preemption, locks memory and keeps it, forbids deep sleep states of the processor.
  RtProcess();
  ~RtProcess();
  RtProcess(const RtProcess&) = delete;
  RtProcess& operator=(const RtProcess&) = delete;

  const std::vector<RtStep>& steps() const noexcept { return steps_; }

 private:
  RtStep forbid_deep_sleep();

  std::vector<RtStep> steps_;
  int latency_fd_ = -1;  // the request is in effect while it is open
};

/// Sets up the calling thread: SCHED_FIFO at rt_priority, stack touched.
std::vector<RtStep> set_up_rt_thread();

/// Above the interrupt threads' 50, below the kernel's own 99.
inline constexpr int rt_priority = 80;

/// Formats one line a step: name, result, detail, remedy.
std::string rt_table(std::span<const RtStep> steps);

/// Opens closed descriptors among 0 to 2 on /dev/null, so that later ones are above them. A bus or file
/// opened as one of them would receive the status lines. Call it before anything else is opened. Returns
/// false if /dev/null cannot be opened.
[[nodiscard]] bool keep_standard_descriptors() noexcept;

/// Calls f in this thread, on a stack of 8 MB if the process's limit (`ulimit -s`) is lower; threads that
/// start meanwhile get as much. Returns false, without calling f, if out of memory.
[[nodiscard]] bool call_on_large_stack(const std::function<void()>& f);

/// Processor and kernel of this machine.
struct Machine {
  std::string cpu;  // model name
  unsigned num_cpus = 0;
  std::string kernel;  // release and version
};

Machine this_machine();

}  // namespace godobject
