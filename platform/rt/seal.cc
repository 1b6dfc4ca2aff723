#include "platform/rt/seal.h"

#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/futex.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <ucontext.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <system_error>
#include <thread>
#include <vector>

namespace godobject {
namespace {

constexpr std::string_view waits = "waits for the next period", time = "time, where there is no vDSO",
                           buses = "buses", program = "program of `--device`", faults = "page faults",
                           wakes = "wakes waiting threads at its end", ends = "end of the thread",
                           dies = "signals, and last frames after a defect";

constexpr std::array calls{
    LoopCall{SYS_clock_nanosleep, "clock_nanosleep", waits},
    LoopCall{SYS_clock_gettime, "clock_gettime", time},
    LoopCall{SYS_ppoll, "ppoll", buses},
    LoopCall{SYS_read, "read", buses},
    LoopCall{SYS_write, "write", buses},
    LoopCall{SYS_recvmsg, "recvmsg", buses},
    LoopCall{SYS_sendto, "sendto", buses},
    LoopCall{SYS_ioctl, "ioctl", buses},
    LoopCall{SYS_timerfd_settime, "timerfd_settime", buses},
    LoopCall{SYS_epoll_ctl, "epoll_ctl", buses},
    LoopCall{SYS_accept4, "accept4", program},
    LoopCall{SYS_setsockopt, "setsockopt", program},
    LoopCall{SYS_recvfrom, "recvfrom", program},
    LoopCall{SYS_close, "close", program},
    LoopCall{SYS_getrusage, "getrusage", faults},
    LoopCall{SYS_futex, "futex", wakes},
    LoopCall{SYS_madvise, "madvise", ends},
    LoopCall{SYS_sigaltstack, "sigaltstack", ends},
    LoopCall{SYS_rt_sigprocmask, "rt_sigprocmask", ends},
    LoopCall{SYS_exit, "exit", ends},
    LoopCall{SYS_rt_sigreturn, "rt_sigreturn", dies},
    LoopCall{SYS_rt_sigaction, "rt_sigaction", dies},
    LoopCall{SYS_restart_syscall, "restart_syscall", dies},
    LoopCall{SYS_getpid, "getpid", dies},
    LoopCall{SYS_gettid, "gettid", dies},
    LoopCall{SYS_tgkill, "tgkill", dies},
    LoopCall{SYS_exit_group, "exit_group", dies},
#ifdef SYS_poll
    LoopCall{SYS_poll, "poll", dies},
#endif
};

struct CallName {
  int number;
  std::string_view name;
};

/// Calls that code in a loop makes by mistake.
constexpr std::array other_calls{CallName{SYS_openat, "openat"},
                                 CallName{SYS_futex, "futex"},
                                 CallName{SYS_mmap, "mmap"},
                                 CallName{SYS_munmap, "munmap"},
                                 CallName{SYS_mremap, "mremap"},
                                 CallName{SYS_mprotect, "mprotect"},
                                 CallName{SYS_brk, "brk"},
                                 CallName{SYS_clone, "clone"},
                                 CallName{SYS_clone3, "clone3"},
                                 CallName{SYS_execve, "execve"},
                                 CallName{SYS_wait4, "wait4"},
                                 CallName{SYS_nanosleep, "nanosleep"},
                                 CallName{SYS_sched_yield, "sched_yield"},
                                 CallName{SYS_lseek, "lseek"},
                                 CallName{SYS_fsync, "fsync"},
                                 CallName{SYS_readv, "readv"},
                                 CallName{SYS_writev, "writev"},
                                 CallName{SYS_pread64, "pread64"},
                                 CallName{SYS_pwrite64, "pwrite64"},
                                 CallName{SYS_fcntl, "fcntl"},
                                 CallName{SYS_newfstatat, "newfstatat"},
                                 CallName{SYS_fstat, "fstat"},
                                 CallName{SYS_socket, "socket"},
                                 CallName{SYS_connect, "connect"},
                                 CallName{SYS_sendmsg, "sendmsg"},
                                 CallName{SYS_getrandom, "getrandom"},
                                 CallName{SYS_gettimeofday, "gettimeofday"},
                                 CallName{SYS_sched_setscheduler, "sched_setscheduler"},
                                 CallName{SYS_kill, "kill"}};

#if defined(__x86_64__)
constexpr std::uint32_t architecture = AUDIT_ARCH_X86_64;
void set_result(ucontext_t& context, int error) noexcept { context.uc_mcontext.gregs[REG_RAX] = -error; }
#elif defined(__aarch64__)
constexpr std::uint32_t architecture = AUDIT_ARCH_AARCH64;
void set_result(ucontext_t& context, int error) noexcept {
  context.uc_mcontext.regs[0] = static_cast<unsigned long long>(-static_cast<long long>(error));
}
#else
constexpr std::uint32_t architecture = 0;  // unknown: no thread can be sealed
void set_result(ucontext_t&, int) noexcept {}
#endif

constexpr sock_filter statement(int code, std::uint32_t k) noexcept {
  return {.code = static_cast<std::uint16_t>(code), .jt = 0, .jf = 0, .k = k};
}
/// Skips the next statement unless the loaded word is k.
constexpr sock_filter unless(std::uint32_t k) noexcept {
  return {.code = BPF_JMP | BPF_JEQ | BPF_K, .jt = 0, .jf = 1, .k = k};
}
constexpr sock_filter load(std::size_t offset) noexcept {
  return statement(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(offset));
}

constexpr sock_filter allow = statement(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
                      trap = statement(BPF_RET | BPF_K, SECCOMP_RET_TRAP);

/// Builds the filter. A futex may only wake: waiting is that of a lock.
std::vector<sock_filter> filter() {
  std::vector<sock_filter> program{load(offsetof(seccomp_data, arch)),
                                   {.code = BPF_JMP | BPF_JEQ | BPF_K, .jt = 1, .jf = 0, .k = architecture},
                                   trap,
                                   load(offsetof(seccomp_data, nr))};
  for (const LoopCall& call : calls) {
    if (call.number == SYS_futex) continue;
    program.push_back(unless(static_cast<std::uint32_t>(call.number)));
    program.push_back(allow);
  }
  const std::array futex{sock_filter{.code = BPF_JMP | BPF_JEQ | BPF_K, .jt = 1, .jf = 0, .k = SYS_futex},
                         trap,
                         load(offsetof(seccomp_data, args) + sizeof(std::uint64_t)),  // little-endian
                         statement(BPF_ALU | BPF_AND | BPF_K, static_cast<std::uint32_t>(FUTEX_CMD_MASK)),
                         unless(FUTEX_WAKE),
                         allow,
                         trap};
  program.insert(program.end(), futex.begin(), futex.end());
  return program;
}

}  // namespace

std::span<const LoopCall> loop_calls() noexcept { return calls; }

std::string_view name_of_call(int number) noexcept {
  const auto known = std::ranges::find(calls, number, &LoopCall::number);
  if (known != calls.end()) return known->name;
  const auto other = std::ranges::find(other_calls, number, &CallName::number);
  return other != other_calls.end() ? other->name : "system call";
}

/// Stores the refused call, which fails. A lock gets EAGAIN and tries again, because the C library aborts at
/// any other error.
void Seal::on_refused(int signal, siginfo_t* info, void* context) {
  constexpr int by_seccomp = 1;  // SYS_SECCOMP, which not every C library defines
  if (info->si_code != by_seccomp) {
    if (former_.sa_handler != SIG_DFL && former_.sa_handler != SIG_IGN) return former_.sa_handler(signal);
    std::signal(signal, SIG_DFL);
    static_cast<void>(raise(signal));
    return;
  }
  const int number = info->si_syscall;
  set_result(*static_cast<ucontext_t*>(context), number == SYS_futex ? EAGAIN : EPERM);
  if (!is_counting_.load(std::memory_order_relaxed)) return;
  int none = -1;
  first_.compare_exchange_strong(none, number);
  num_refused_.fetch_add(1);
}

Seal::Seal() noexcept {
  is_counting_ = true;
  first_ = -1;
  num_refused_ = 0;
  struct sigaction action {};
  action.sa_sigaction = on_refused;
  action.sa_flags = SA_SIGINFO | SA_ONSTACK;
  sigaction(SIGSYS, &action, &former_);
}

Seal::~Seal() { sigaction(SIGSYS, &former_, nullptr); }

RtStep Seal::close() {
  RtStep step{.name = "seal", .result = RtResult::ok, .detail = "", .remedy = ""};
  std::vector<sock_filter> program = filter();
  const sock_fprog given{.len = static_cast<unsigned short>(program.size()), .filter = program.data()};
  is_counting_ = true;
  const bool sealed = architecture != 0 && prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
                      prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &given) == 0;
  if (sealed) {
    step.detail = "the loop makes " + std::to_string(calls.size()) + " system calls and no others";
    return step;
  }
  step.result = RtResult::failed;
  step.detail = architecture == 0 ? "no filter for this processor" : std::generic_category().message(errno);
  step.remedy = "use a kernel with CONFIG_SECCOMP_FILTER, or run without --seal";
  return step;
}

std::string Seal::why_not() {
  RtStep step;
  std::thread([&step] { step = Seal().close(); }).join();
  return step.result == RtResult::ok ? "" : step.detail + "; " + step.remedy;
}

std::string Seal::text() const {
  const int number = first_;
  if (!is_broken()) return "";
  return "the loop called " + std::string(name_of_call(number)) + " (" + std::to_string(number) +
         "), which the seal refuses";
}

}  // namespace godobject
