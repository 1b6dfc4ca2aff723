#include "platform/rt/machine_files.h"

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

namespace fs = std::filesystem;

RtStep look_at_kernel(const fs::path& root) {
  RtStep step{.name = "kernel", .result = RtResult::ok, .detail = "PREEMPT_RT", .remedy = ""};
  if (has_preempt_rt(root)) return step;
  const bool is_known = line_of(root / "proc/version").has_value();
  step.result = is_known ? RtResult::degraded : RtResult::failed;
  step.detail = is_known ? "not PREEMPT_RT: wake-ups may be late by milliseconds"
                         : "unknown, because /proc/version cannot be read";
  step.remedy = is_known ? "apt install linux-image-rt-amd64 && reboot" : "mount -t proc proc /proc";
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
  if (step.result != RtResult::ok) step.remedy = raise_limit("memlock unlimited");
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
          .remedy = "env -u LD_PRELOAD godobject run ..."};
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

RtStep keep_threads_off(unsigned core, const fs::path& root) {
  RtStep step{.name = "other threads", .result = RtResult::ok, .detail = "", .remedy = ""};
  const int num_moved = keep_off(core, root);
  step.detail = "of this program: off core " + std::to_string(core);
  if (num_moved >= 0) return step;
  step.result = RtResult::degraded;
  step.detail = "of this program share core " + std::to_string(core) + ": " + error_text(-num_moved);
  step.remedy =
      "give the program a second core: taskset -c " + list_of(online_cores(root)) + " godobject run ...";
  return step;
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
  return line_of(root / "sys/kernel/realtime") == "1" ||
         line_of(root / "proc/version").value_or("").find("PREEMPT_RT") != std::string::npos;
}

RtProcess::RtProcess(const MachineAccess& access, const RtThreadPlan& plan)
    : steps_{look_at_kernel(access.root), lock_memory(access), keep_heap()} {
  steps_.push_back(forbid_deep_sleep(access.root));
  if (plan.core) steps_.push_back(keep_threads_off(*plan.core, access.root));
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
  step.remedy = R"(echo 'KERNEL=="cpu_dma_latency", GROUP="godobject", MODE="0660"' )"
                "> /etc/udev/rules.d/99-godobject.rules && udevadm control --reload && "
                "udevadm trigger --name-match=cpu_dma_latency && usermod -aG godobject $USER, or " +
                boot_with("processor.max_cstate=1");
  return step;
}

std::vector<RtStep> set_up_rt_thread(const MachineAccess& access, const RtThreadPlan& plan) {
  std::vector<RtStep> steps = take_scheduling(access, plan);
  steps.push_back(prefault_stack());
  return steps;
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
  // With a limit of all addresses the kernel may refuse to let the present stack grow, by a SIGSEGV.
  rlimit stack{}, addresses{};
  const bool suffices = getrlimit(RLIMIT_STACK, &stack) != 0 || !is_small(stack);
  if (suffices && (getrlimit(RLIMIT_AS, &addresses) != 0 || addresses.rlim_cur == RLIM_INFINITY)) {
    f();
    return true;
  }
  if (!suffices) give_threads_as_much();
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
