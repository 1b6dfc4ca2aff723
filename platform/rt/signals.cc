#include "platform/rt/signals.h"

#include <poll.h>
#include <pthread.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <new>
#include <string_view>

namespace godobject {
namespace {

constexpr int patience_ms = 50;  // limit for a bus that accepts no more bytes
constexpr int settling_ms = 2;   // limit for a write that another thread has begun
constexpr std::size_t stack_size = 1 << 16;

struct DeadlySignal {
  int signal;
  const char* name;
};
constexpr std::array<DeadlySignal, 7> deadly_signals{{{SIGABRT, "SIGABRT"},
                                                      {SIGSEGV, "SIGSEGV"},
                                                      {SIGBUS, "SIGBUS"},
                                                      {SIGFPE, "SIGFPE"},
                                                      {SIGILL, "SIGILL"},
                                                      {SIGSYS, "SIGSYS"},
                                                      {SIGTRAP, "SIGTRAP"}}};

std::atomic<const std::vector<LastWords>*> registered{nullptr};
static_assert(std::atomic<const std::vector<LastWords>*>::is_always_lock_free, "read in a signal handler");
std::atomic<bool> done{false};
std::atomic<const termios*> kept_modes{nullptr};

// From here to on_deadly_signal(): async-signal-safe, without allocation.

void sleep_ms(int ms) noexcept { static_cast<void>(::poll(nullptr, 0, ms)); }

/// Writes to standard error, unless that would block.
void say(std::string_view text) noexcept {
  pollfd out{.fd = STDERR_FILENO, .events = POLLOUT, .revents = 0};
  if (::poll(&out, 1, 0) == 1 && (out.revents & POLLOUT) != 0)
    static_cast<void>(!::write(STDERR_FILENO, text.data(), text.size()));
}

void write_all(int descriptor, std::string_view bytes) noexcept {
  for (int tries = 0; !bytes.empty() && tries < patience_ms; ++tries) {
    const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    if (written >= 0) {
      bytes.remove_prefix(static_cast<std::size_t>(written));
    } else if (errno == EAGAIN || errno == ENOBUFS) {
      sleep_ms(1);
    } else if (errno != EINTR) {
      return;
    }
  }
}

/// Writes the last frames, once. Returns true if there were any.
bool speak() noexcept {
  if (!BusWrite::end()) {  // another thread writes them and then dies of its signal
    for (int ms = 0; ms < 4 * patience_ms && !done; ++ms) sleep_ms(1);
    return false;
  }
  for (int ms = 0; ms < settling_ms && !BusWrite::none_is_going_on(); ++ms) sleep_ms(1);
  const std::vector<LastWords>* const buses = registered.load();
  if (buses)
    for (const LastWords& bus : *buses) {
      if (bus.rest != nullptr) write_all(bus.descriptor, bus.rest->text());
      for (const std::string& frame : bus.writes) write_all(bus.descriptor, frame);
    }
  done = true;
  return buses != nullptr;
}

constexpr std::string_view motors_off = "; the drives were commanded to switch their motors off\n";

void on_deadly_signal(int signal) {
  const int error = errno;
  const bool spoken = speak();
  if (const termios* const modes = kept_modes.load()) tcsetattr(STDIN_FILENO, TCSANOW, modes);
  for (const DeadlySignal& deadly : deadly_signals) {
    if (deadly.signal != signal) continue;
    say("godobject: ended by ");
    say(deadly.name);
    say(spoken ? motors_off : "\n");
  }
  // The signal stays pending until the handler returns. Its default action, including the core dump, follows.
  std::signal(signal, SIG_DFL);
  static_cast<void>(raise(signal));
  errno = error;
}

/// Handles std::terminate: first switches the motors off, then prints the exception's text. No signal
/// handler, so this may allocate.
[[noreturn]] void on_terminate() noexcept {
  const bool spoken = speak();
  const char* what = "terminated";
  std::exception_ptr exception = std::current_exception();
  try {
    if (exception) std::rethrow_exception(exception);
  } catch (const std::exception& error) {
    what = error.what();
  } catch (...) {
    what = "an exception of an unknown type";
  }
  say("godobject: a defect of the program: ");
  say(what);
  say(spoken ? motors_off : "\n");
  std::abort();
}

constexpr std::array rows{
    SignalRow{SIGINT, "SIGINT", SignalFate::stop},
    SignalRow{SIGTERM, "SIGTERM", SignalFate::stop},
    SignalRow{SIGHUP, "SIGHUP", SignalFate::stop},
    SignalRow{SIGQUIT, "SIGQUIT", SignalFate::stop},
    SignalRow{SIGTSTP, "SIGTSTP", SignalFate::stop},
    SignalRow{SIGALRM, "SIGALRM", SignalFate::stop},
    SignalRow{SIGVTALRM, "SIGVTALRM", SignalFate::stop},
    SignalRow{SIGPROF, "SIGPROF", SignalFate::stop},
    SignalRow{SIGUSR1, "SIGUSR1", SignalFate::stop},
    SignalRow{SIGUSR2, "SIGUSR2", SignalFate::stop},
    SignalRow{SIGIO, "SIGIO", SignalFate::stop},
    SignalRow{SIGPWR, "SIGPWR", SignalFate::stop},
    SignalRow{SIGSTKFLT, "SIGSTKFLT", SignalFate::stop},
    SignalRow{SIGXCPU, "SIGXCPU", SignalFate::stop},
    SignalRow{SIGPIPE, "SIGPIPE", SignalFate::ignored},
    SignalRow{SIGXFSZ, "SIGXFSZ", SignalFate::ignored},
    SignalRow{SIGTTOU, "SIGTTOU", SignalFate::ignored},
    SignalRow{SIGTTIN, "SIGTTIN", SignalFate::ignored},
    SignalRow{SIGABRT, "SIGABRT", SignalFate::last_resort},
    SignalRow{SIGSEGV, "SIGSEGV", SignalFate::last_resort},
    SignalRow{SIGBUS, "SIGBUS", SignalFate::last_resort},
    SignalRow{SIGFPE, "SIGFPE", SignalFate::last_resort},
    SignalRow{SIGILL, "SIGILL", SignalFate::last_resort},
    SignalRow{SIGSYS, "SIGSYS", SignalFate::last_resort},
    SignalRow{SIGTRAP, "SIGTRAP", SignalFate::last_resort},
};
static_assert(rows.size() <= StopSignals::max_signals);

sigset_t signals_of(SignalFate fate) noexcept {
  sigset_t set;
  sigemptyset(&set);
  for (const SignalRow& row : rows)
    if (row.fate == fate) sigaddset(&set, row.signal);
  return set;
}

/// Unblocks the deadly signals, which the parent process may have blocked. A blocked one would end the
/// process without its handler.
void unblock_deadly_signals() noexcept {
  const sigset_t deadly = signals_of(SignalFate::last_resort);
  pthread_sigmask(SIG_UNBLOCK, &deadly, nullptr);
}

}  // namespace

LastResort::LastResort(std::vector<LastWords> buses) : buses_(std::move(buses)) { registered = &buses_; }

LastResort::~LastResort() { registered = nullptr; }

void LastResort::keep(const termios* of_terminal) noexcept { kept_modes = of_terminal; }

void LastResort::install() {
  std::set_terminate(on_terminate);
  struct sigaction action {};
  action.sa_handler = on_deadly_signal;
  action.sa_flags = SA_ONSTACK;
  for (const DeadlySignal& deadly : deadly_signals) sigaction(deadly.signal, &action, nullptr);
}

SignalStack::SignalStack() noexcept : memory_(new (std::nothrow) char[stack_size]) {
  if (!memory_) return;
  stack_t stack{};
  stack.ss_sp = memory_.get();
  stack.ss_size = stack_size;
  sigaltstack(&stack, nullptr);
}

SignalStack::~SignalStack() {
  stack_t none{};
  none.ss_flags = SS_DISABLE;
  sigaltstack(&none, nullptr);
}

std::span<const SignalRow> signal_rows() noexcept { return rows; }

void guard_process() {
  static const SignalStack stack;  // stack for signal handlers of the main thread
  LastResort::install();
  unblock_deadly_signals();
  struct sigaction ignore {};
  ignore.sa_handler = SIG_IGN;
  for (const SignalRow& row : rows)
    if (row.fate == SignalFate::ignored) sigaction(row.signal, &ignore, nullptr);
}

void block_stop_signals() noexcept {
  sigset_t stops = signals_of(SignalFate::stop);
  for (int signal = SIGRTMIN; signal <= SIGRTMAX; ++signal) sigaddset(&stops, signal);
  pthread_sigmask(SIG_BLOCK, &stops, nullptr);
  unblock_deadly_signals();
}

ThreadSetup::ThreadSetup(const char* name) noexcept {
  block_stop_signals();
  pthread_setname_np(pthread_self(), name);
}

void StopSignals::on_signal(int signal) {
  int none = 0;
  if (signal_.compare_exchange_strong(none, signal)) requested_ = true;
  else insisted_ = true;
}

StopSignals::StopSignals(Suspension suspension) noexcept {
  requested_ = insisted_ = key_ = false;
  signal_ = 0;
  struct sigaction action {};
  action.sa_handler = on_signal;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const SignalRow& row = rows[i];
    if (row.fate != SignalFate::stop) continue;
    if (row.signal == SIGTSTP && suspension == Suspension::allowed) continue;
    sigaction(row.signal, &action, &former_[i]);
    const bool nohup = row.signal == SIGHUP && former_[i].sa_handler == SIG_IGN;
    if (nohup) sigaction(row.signal, &former_[i], nullptr);
    caught_[i] = !nohup;
  }
  for (int signal = SIGRTMIN; signal <= SIGRTMAX; ++signal) sigaction(signal, &action, nullptr);
}

StopSignals::~StopSignals() {
  struct sigaction by_default {};
  by_default.sa_handler = SIG_DFL;
  for (int signal = SIGRTMIN; signal <= SIGRTMAX; ++signal) sigaction(signal, &by_default, nullptr);
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (caught_[i]) sigaction(rows[i].signal, &former_[i], nullptr);
}

std::string_view StopSignals::name() const noexcept {
  if (signal_ == 0 && key_) return "space bar";
  if (signal_ >= SIGRTMIN) return "SIGRTMIN";
  const auto row = std::ranges::find(rows, signal_.load(), &SignalRow::signal);
  return row == rows.end() ? "" : row->name;
}

}  // namespace godobject
