// Real-time setup of Linux, step by step. Each step has a result, so that no failure is silent.
#pragma once

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

}  // namespace godobject
