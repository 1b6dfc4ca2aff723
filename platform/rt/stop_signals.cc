#include "platform/rt/stop_signals.h"

#include <pthread.h>

#include <algorithm>
#include <array>

namespace godobject {
namespace {

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
  requested_ = insisted_ = false;
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
  if (signal_ >= SIGRTMIN) return "SIGRTMIN";
  const auto row = std::ranges::find(rows, signal_.load(), &SignalRow::signal);
  return row == rows.end() ? "" : row->name;
}

}  // namespace godobject
