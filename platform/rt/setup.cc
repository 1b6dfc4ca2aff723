#include "platform/rt/setup.h"

#include <fcntl.h>
#include <malloc.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/utsname.h>
#include <ucontext.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <system_error>
#include <thread>

namespace godobject {
namespace {

constexpr std::size_t prefault_bytes = std::size_t{256} * 1024;

std::string error_text(int error) { return std::generic_category().message(error); }

RtStep look_at_kernel() {
  int realtime = 0;
  std::ifstream("/sys/kernel/realtime") >> realtime;
  if (realtime == 1) return {.name = "kernel", .result = RtResult::ok, .detail = "PREEMPT_RT", .remedy = ""};
  return {.name = "kernel",
          .result = RtResult::degraded,
          .detail = "not PREEMPT_RT: wake-ups may be late by milliseconds",
          .remedy = "apt install linux-image-rt-amd64, then boot it"};
}

/// Locks memory. Future memory is locked only without a limit on locked memory, because otherwise later
/// allocations would fail.
RtStep lock_memory() {
  rlimit limit{};
  getrlimit(RLIMIT_MEMLOCK, &limit);
  const bool unlimited = limit.rlim_cur == RLIM_INFINITY || geteuid() == 0;
  RtStep step{
      .name = "lock memory", .result = RtResult::ok, .detail = "all present and future memory", .remedy = ""};
  if (mlockall(unlimited ? MCL_CURRENT | MCL_FUTURE : MCL_CURRENT) != 0) {
    step.result = RtResult::failed;
    step.detail = "mlockall: " + error_text(errno);
  } else if (!unlimited) {
    step.result = RtResult::degraded;
    step.detail = "present memory only; " + std::to_string(limit.rlim_cur / 1024) + " KiB is the limit";
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

RtStep take_priority() {
  sched_param param{};
  param.sched_priority = rt_priority;
  const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &param);
  const std::string wanted = "SCHED_FIFO " + std::to_string(rt_priority);
  if (error == 0) return {.name = "priority", .result = RtResult::ok, .detail = wanted, .remedy = ""};
  return {.name = "priority",
          .result = RtResult::degraded,
          .detail = wanted + ": " + error_text(error) + "; runs at normal priority",
          .remedy = "'<user> - rtprio 98' in /etc/security/limits.d/, and log in again"};
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
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (!line.starts_with("model name")) continue;
    const std::size_t colon = line.find(": ");
    if (colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

}  // namespace

std::string_view name_of(RtResult result) noexcept {
  constexpr std::array<std::string_view, 3> names{"ok", "degraded", "failed"};
  return names[static_cast<std::size_t>(result)];
}

RtProcess::RtProcess() : steps_{look_at_kernel(), lock_memory(), keep_heap()} {
  steps_.push_back(forbid_deep_sleep());
}

RtProcess::~RtProcess() {
  if (latency_fd_ >= 0) close(latency_fd_);
  munlockall();
}

/// Limits the wake-up latency of the processors while the file is open (pm_qos_interface.rst in Linux's
/// Documentation/power).
RtStep RtProcess::forbid_deep_sleep() {
  RtStep step{
      .name = "processor sleep", .result = RtResult::ok, .detail = "no deep idle states", .remedy = ""};
  latency_fd_ = open("/dev/cpu_dma_latency", O_WRONLY | O_CLOEXEC);
  const std::int32_t longest_us = 0;
  if (latency_fd_ < 0 || write(latency_fd_, &longest_us, sizeof longest_us) != sizeof longest_us) {
    step.result = RtResult::degraded;
    step.detail = "/dev/cpu_dma_latency: " + error_text(errno);
    step.remedy = "give the user write permission on it (udev rule), or boot with processor.max_cstate=1";
  }
  return step;
}

std::vector<RtStep> set_up_rt_thread() { return {take_priority(), prefault_stack()}; }

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
