// Scheduling of the loop's thread: SCHED_FIFO or SCHED_DEADLINE, and its core (sched(7), and sched-deadline
// in Linux's Documentation/scheduler).
#include <linux/capability.h>
#include <pthread.h>
#include <sched.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "platform/rt/machine_files.h"

namespace godobject {
namespace {

namespace fs = std::filesystem;

int take_fifo(int priority) {
  sched_param param{};
  param.sched_priority = priority;
  return pthread_setschedparam(pthread_self(), SCHED_FIFO, &param);
}

/// Sets SCHED_DEADLINE for this thread; the period is also its deadline. Not every C library has the call.
int take_deadline(Nanoseconds runtime, Nanoseconds period) {
  struct {
    std::uint32_t size = sizeof(*this), policy = 6;  // SCHED_DEADLINE
    std::uint64_t flags = 0;
    std::int32_t nice = 0;
    std::uint32_t priority = 0;
    std::uint64_t runtime = 0, deadline = 0, period = 0;  // ns
  } attributes;
  attributes.runtime = static_cast<std::uint64_t>(runtime);
  attributes.deadline = attributes.period = static_cast<std::uint64_t>(period);
  return syscall(SYS_sched_setattr, 0, &attributes, 0) == 0 ? 0 : errno;
}

int move_to(pid_t thread, const cpu_set_t& cores) {
  return sched_setaffinity(thread, sizeof cores, &cores) == 0 ? 0 : errno;
}

int move_to_core(unsigned core) {
  cpu_set_t cores;
  CPU_ZERO(&cores);
  CPU_SET(core, &cores);
  return move_to(0, cores);
}

RtStep take_priority(const MachineAccess& access) {
  const auto take = [&](int priority) {
    return access.take_priority ? access.take_priority(priority) : take_fifo(priority);
  };
  const std::string wanted = "SCHED_FIFO " + std::to_string(rt_priority);
  RtStep step{.name = "priority", .result = RtResult::ok, .detail = wanted, .remedy = ""};
  const int error = take(rt_priority);
  if (error == 0) return step;
  const std::uint64_t limit = limit_of(access.root, "Max realtime priority");
  const bool is_limit = limit < rt_priority && !has_capability(access.root, CAP_SYS_NICE);
  step.remedy = is_limit ? raise_limit("rtprio 98")
                         : "echo 950000 > /sys/fs/cgroup/cpu$(sed -n 's/.*:cpu,cpuacct://p' "
                           "/proc/self/cgroup)/cpu.rt_runtime_us; in a container: "
                           "--cap-add=SYS_NICE --ulimit rtprio=98";
  if (is_limit && limit > 0 && take(static_cast<int>(limit)) == 0) {
    step.result = RtResult::degraded;
    step.detail = "SCHED_FIFO " + std::to_string(limit) + ", the limit of rtprio, instead of " + wanted;
  } else {
    step.result = RtResult::failed;
    step.detail = wanted + ": " + error_text(error) + "; runs at normal priority";
  }
  return step;
}

/// Returns the remedy of a refused SCHED_DEADLINE. No limit of a user permits it, only a capability. The
/// kernel refuses threads that may not run on each core of their group.
std::string deadline_remedy(int error, const fs::path& root) {
  switch (error) {
    case EPERM:
      if (!has_capability(root, CAP_SYS_NICE))
        return "setcap cap_sys_nice+ep $(command -v godobject); in a container: --cap-add=SYS_NICE";
      return "start it on all cores: taskset -c " + list_of(online_cores(root)) + " godobject run ...";
    case EBUSY:
      return "sysctl -w kernel.sched_rt_runtime_us=950000, end other SCHED_DEADLINE programs, or give "
             "--deadline less";
    case EINVAL: return "sysctl -w kernel.sched_deadline_period_min_us=100, and a step of 1e-4 s or more";
    default: return "use a kernel with SCHED_DEADLINE, or run without --deadline";
  }
}

RtStep take_deadline(const MachineAccess& access, const RtThreadPlan& plan) {
  const std::string wanted = "SCHED_DEADLINE " + std::to_string(plan.runtime_ns / 1000) + " us of each " +
                             std::to_string(plan.period_ns / 1000) + " us";
  RtStep step{.name = deadline_step, .result = RtResult::ok, .detail = wanted, .remedy = ""};
  const int error = access.take_deadline ? access.take_deadline(plan.runtime_ns, plan.period_ns)
                                         : take_deadline(plan.runtime_ns, plan.period_ns);
  if (error == 0) return step;
  step.result = RtResult::failed;
  step.detail = wanted + ": " + error_text(error) + "; runs at normal priority";
  step.remedy = deadline_remedy(error, access.root);
  return step;
}

RtStep take_core(const MachineAccess& access, unsigned core) {
  RtStep step{.name = core_step, .result = RtResult::ok, .detail = std::to_string(core), .remedy = ""};
  const int error = access.take_core ? access.take_core(core) : move_to_core(core);
  if (error != 0) {
    step.result = RtResult::failed;
    step.detail += ": " + error_text(error) + "; runs on any core";
    step.remedy = "give its control group the core: systemctl set-property NAME.service AllowedCPUs=" +
                  list_of(online_cores(access.root)) + "; in a container: --cpuset-cpus";
  } else if (isolated_cores(access.root).contains(core)) {
    step.detail += ", isolated";
  } else {
    step.result = RtResult::degraded;
    step.detail += "; other programs and interrupts may run there too";
    step.remedy = boot_with(isolation_of(core, online_cores(access.root)));
  }
  return step;
}

}  // namespace

std::vector<RtStep> take_scheduling(const MachineAccess& access, const RtThreadPlan& plan) {
  std::vector<RtStep> steps;
  if (plan.core) steps.push_back(take_core(access, *plan.core));
  steps.push_back(plan.runtime_ns > 0 ? take_deadline(access, plan) : take_priority(access));
  return steps;
}

int keep_off(unsigned core, const fs::path& root) {
  int num_moved = 0;
  std::error_code error;
  for (const fs::directory_entry& thread : fs::directory_iterator(root / "proc/self/task", error)) {
    const auto id = static_cast<pid_t>(std::strtol(thread.path().filename().c_str(), nullptr, 10));
    cpu_set_t cores;
    if (sched_getaffinity(id, sizeof cores, &cores) != 0 || !CPU_ISSET(core, &cores)) continue;
    CPU_CLR(core, &cores);
    if (CPU_COUNT(&cores) == 0) return -EINVAL;
    if (const int refused = move_to(id, cores); refused == 0) ++num_moved;
    else if (refused != ESRCH) return -refused;
  }
  return error ? -error.value() : num_moved;
}

}  // namespace godobject
