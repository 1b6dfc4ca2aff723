#include "platform/rt/setup.h"

#include <fcntl.h>
#include <linux/capability.h>
#include <malloc.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/utsname.h>
#include <ucontext.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <sstream>
#include <string_view>
#include <system_error>
#include <thread>

namespace godobject {
namespace {

constexpr std::size_t prefault_bytes = std::size_t{256} * 1024;

std::string error_text(int error) { return std::generic_category().message(error); }

namespace fs = std::filesystem;

/// Returns the first line of a file; none if it cannot be read.
std::optional<std::string> first_line(const fs::path& path) {
  std::ifstream file(path);
  std::string line;
  if (!std::getline(file, line)) return std::nullopt;
  return line;
}

/// Returns the text after `name` in /proc/self/limits or /proc/self/status; empty if there is none.
std::string text_after(const fs::path& path, std::string_view name) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);)
    if (line.starts_with(name)) return line.substr(name.size());
  return "";
}

/// Returns a limit of this process; UINT64_MAX: not limited, 0: unknown.
std::uint64_t limit_of(const fs::path& root, std::string_view name) {
  std::istringstream columns(text_after(root / "proc/self/limits", name));
  std::string limit;
  columns >> limit;
  return limit == "unlimited" ? UINT64_MAX : std::strtoull(limit.c_str(), nullptr, 10);
}

/// True if this process has the capability of this number (capabilities(7)), for which limits do not apply.
bool has_capability(const fs::path& root, unsigned number) {
  std::istringstream mask(text_after(root / "proc/self/status", "CapEff:"));
  std::uint64_t bits = 0;
  return static_cast<bool>(mask >> std::hex >> bits) && (bits >> number & 1) != 0;
}

RtStep look_at_kernel(const fs::path& root) {
  RtStep step{.name = "kernel", .result = RtResult::ok, .detail = "PREEMPT_RT", .remedy = ""};
  if (has_preempt_rt(root)) return step;
  const bool is_known = first_line(root / "proc/version").has_value();
  step.result = is_known ? RtResult::degraded : RtResult::failed;
  step.detail = is_known ? "not PREEMPT_RT: wake-ups may be late by milliseconds"
                         : "unknown, because /proc/version cannot be read";
  step.remedy = is_known ? "apt install linux-image-rt-amd64, then boot it" : "mount -t proc proc /proc";
  return step;
}

/// Locks memory. Future memory is locked only without a limit on locked memory, because otherwise later
/// allocations would fail.
RtStep lock_memory(const MachineAccess& access) {
  const std::uint64_t limit = limit_of(access.root, "Max locked memory");
  const bool unlimited = limit == UINT64_MAX || has_capability(access.root, CAP_IPC_LOCK);
  RtStep step{
      .name = "lock memory", .result = RtResult::ok, .detail = "all present and future memory", .remedy = ""};
  const int flags = unlimited ? MCL_CURRENT | MCL_FUTURE : MCL_CURRENT;
  const int error = access.lock_memory ? access.lock_memory(flags) : mlockall(flags) == 0 ? 0 : errno;
  if (error != 0) {
    step.result = RtResult::failed;
    step.detail = "mlockall: " + error_text(error);
  } else if (!unlimited) {
    step.result = RtResult::degraded;
    step.detail = "present memory only; " + std::to_string(limit / 1024) + " KiB is the limit";
  }
  if (step.result != RtResult::ok)
    step.remedy = "'<user> - memlock unlimited' in /etc/security/limits.d/, and log in again";
  return step;
}

/// Keeps freed memory in the process, because reusing returned memory costs a page fault.
RtStep keep_heap() {
  const bool kept = mallopt(M_TRIM_THRESHOLD, -1) == 1 && mallopt(M_MMAP_MAX, 0) == 1;
  if (kept)
    return {.name = "keep heap",
            .result = RtResult::ok,
            .detail = "freed memory stays in the process",
            .remedy = ""};
  return {.name = "keep heap",
          .result = RtResult::degraded,
          .detail = "the allocator refused",
          .remedy = "run without a replacement of malloc (LD_PRELOAD)"};
}

/// Touches the stack below this call, so that the loop meets no page fault there.
[[gnu::noinline]] RtStep prefault_stack() {
  std::array<volatile unsigned char, prefault_bytes> pages;
  constexpr std::size_t page = 4096;
  for (std::size_t i = 0; i < pages.size(); i += page) pages[i] = 0;
  return {.name = "touch stack",
          .result = RtResult::ok,
          .detail = std::to_string(prefault_bytes / 1024) + " KiB",
          .remedy = ""};
}

int take_fifo(int priority) {
  sched_param param{};
  param.sched_priority = priority;
  return pthread_setschedparam(pthread_self(), SCHED_FIFO, &param);
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
  step.remedy = is_limit
                    ? "'<user> - rtprio 98' in /etc/security/limits.d/, and log in again"
                    : "give the control group of this program cpu.rt_runtime_us above 0; in a container: "
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

/// Returns the longest wake-up latency of the idle states in use, us; none if there are no idle states.
std::optional<std::uint64_t> longest_wake_up_us(const fs::path& root) {
  std::optional<std::uint64_t> longest;
  std::error_code ignored;
  for (const fs::directory_entry& cpu : fs::directory_iterator(root / "sys/devices/system/cpu", ignored))
    for (const fs::directory_entry& state : fs::directory_iterator(cpu.path() / "cpuidle", ignored)) {
      std::uint64_t latency = 0, disabled = 0;
      std::ifstream(state.path() / "disable") >> disabled;
      if (disabled == 0 && std::ifstream(state.path() / "latency") >> latency)
        longest = std::max(longest.value_or(0), latency);
    }
  return longest;
}

constexpr std::size_t stack_bytes = std::size_t{8} << 20;  // Linux' usual limit

bool is_small(const rlimit& limit) noexcept {
  return limit.rlim_cur != RLIM_INFINITY && limit.rlim_cur < stack_bytes;
}

void give_threads_as_much() noexcept {
  pthread_attr_t attributes;
  if (pthread_attr_init(&attributes) != 0) return;
  if (pthread_attr_setstacksize(&attributes, stack_bytes) == 0) pthread_setattr_default_np(&attributes);
  pthread_attr_destroy(&attributes);
}

const std::function<void()>* called = nullptr;  // global, because makecontext() passes no pointers

void enter() { (*called)(); }

std::string cpu_model() {
  const std::string text = text_after("/proc/cpuinfo", "model name");
  const std::size_t colon = text.find(": ");
  return colon == std::string::npos ? "unknown" : text.substr(colon + 2);
}

}  // namespace

std::string_view name_of(RtResult result) noexcept {
  constexpr std::array<std::string_view, 3> names{"ok", "degraded", "failed"};
  return names[static_cast<std::size_t>(result)];
}

// Kernels since 6.12 have PREEMPT_RT without the file `realtime`.
bool has_preempt_rt(const fs::path& root) {
  return first_line(root / "sys/kernel/realtime") == "1" ||
         first_line(root / "proc/version").value_or("").find("PREEMPT_RT") != std::string::npos;
}

RtProcess::RtProcess(const MachineAccess& access)
    : steps_{look_at_kernel(access.root), lock_memory(access), keep_heap()} {
  steps_.push_back(forbid_deep_sleep(access.root));
}

RtProcess::~RtProcess() {
  if (latency_fd_ >= 0) close(latency_fd_);
  munlockall();
}

/// Limits the wake-up latency of the processors while the file is open (pm_qos_interface.rst in Linux's
/// Documentation/power).
RtStep RtProcess::forbid_deep_sleep(const fs::path& root) {
  constexpr std::uint64_t short_us = 10, period_us = 1000;  // the latency of C1E; a period at 1 kHz
  RtStep step{
      .name = "processor sleep", .result = RtResult::ok, .detail = "no deep idle states", .remedy = ""};
  latency_fd_ = open((root / "dev/cpu_dma_latency").c_str(), O_WRONLY | O_CLOEXEC);
  const std::int32_t longest_us = 0;
  if (latency_fd_ >= 0 && write(latency_fd_, &longest_us, sizeof longest_us) == sizeof longest_us)
    return step;
  const std::string why = "/dev/cpu_dma_latency: " + error_text(errno);
  const std::optional<std::uint64_t> wake_up = longest_wake_up_us(root);
  if (wake_up && *wake_up <= short_us) return step;
  step.result = wake_up && *wake_up >= period_us ? RtResult::failed : RtResult::degraded;
  step.detail = why + (wake_up ? "; wake-ups take up to " + std::to_string(*wake_up) + " us" : "");
  step.remedy =
      R"(put KERNEL=="cpu_dma_latency", GROUP="godobject", MODE="0660" into /etc/udev/rules.d/99-godobject.rules, )"
      "with the user in that group, or boot with processor.max_cstate=1";
  return step;
}

std::vector<RtStep> set_up_rt_thread(const MachineAccess& access) {
  return {take_priority(access), prefault_stack()};
}

std::string rt_table(std::span<const RtStep> steps) {
  std::string table;
  for (const RtStep& step : steps) {
    std::array<char, 64> head{};
    std::snprintf(head.data(), head.size(), "  %-16s %-9s ", step.name.c_str(),
                  std::string(name_of(step.result)).c_str());
    table += head.data() + step.detail;
    if (!step.remedy.empty()) table += "\n                             -> " + step.remedy;
    table += '\n';
  }
  return table;
}

bool keep_standard_descriptors() noexcept {
  for (int standard = STDIN_FILENO; standard <= STDERR_FILENO; ++standard) {
    if (::fcntl(standard, F_GETFD) >= 0) continue;
    int opened = -1;  // the lowest free number, which is this one
    do {
      opened = ::open("/dev/null", O_RDWR);
    } while (opened < 0 && errno == EINTR);
    if (opened < 0) return false;
  }
  return true;
}

bool call_on_large_stack(const std::function<void()>& f) {
  rlimit limit{};
  if (getrlimit(RLIMIT_STACK, &limit) != 0 || !is_small(limit)) {
    f();
    return true;
  }
  give_threads_as_much();
  const auto guard_bytes = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  const std::size_t bytes = stack_bytes + guard_bytes;
  void* const memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE,
                            MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE | MAP_STACK, -1, 0);
  if (memory == MAP_FAILED) return false;
  mprotect(memory, guard_bytes, PROT_NONE);  // turns an overflow into a SIGSEGV
  ucontext_t caller{}, context{};
  getcontext(&context);
  context.uc_stack.ss_sp = static_cast<std::byte*>(memory) + guard_bytes;
  context.uc_stack.ss_size = stack_bytes;
  context.uc_link = &caller;
  called = &f;
  makecontext(&context, enter, 0);
  swapcontext(&caller, &context);
  munmap(memory, bytes);
  return true;
}

Machine this_machine() {
  utsname names{};
  uname(&names);
  return {.cpu = cpu_model(),
          .num_cpus = std::thread::hardware_concurrency(),
          .kernel = std::string(names.release) + " " + names.version};
}

}  // namespace godobject
