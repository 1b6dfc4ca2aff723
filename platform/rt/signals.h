// Effect of every signal: ends the run, is ignored, or ends the process after the last frames. Last frames
// switch the motors of a dying program off. They are encoded beforehand and written by the handler of the
// deadly signal. Process-wide, for one rig at a time.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <csignal>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

struct termios;

namespace godobject {

/// Rest of a line that a short write cut off, for buses of text lines: the last frames follow it. The writing
/// thread stores it within a BusWrite; the last resort reads it.
class LineRest {
 public:
  void store(std::string_view rest) noexcept {
    size_ = 0;
    const std::size_t size = std::min(rest.size(), text_.size());
    std::copy_n(rest.begin(), size, text_.begin());
    size_ = size;
  }
  std::string_view text() const noexcept { return {text_.data(), size_.load()}; }

 private:
  std::array<char, 64> text_{};
  std::atomic<std::size_t> size_{0};
  static_assert(std::atomic<std::size_t>::is_always_lock_free, "read in a signal handler");
};

/// Last frames on one bus, in the order of writing. Each is one write, because a write to a CAN socket is one
/// frame.
struct LastWords {
  int descriptor = -1;  // non-blocking; -1: the bus is closed, nothing is written
  std::vector<std::string> writes;
  const LineRest* rest = nullptr;  // written first; null: the bus has no lines
};

/// Writes its frames if the process dies by a defect, as long as this object exists. A defect is SIGABRT,
/// SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGSYS, SIGTRAP or std::terminate. One at a time.
class LastResort {
 public:
  explicit LastResort(std::vector<LastWords> buses);
  ~LastResort();
  LastResort(const LastResort&) = delete;
  LastResort& operator=(const LastResort&) = delete;

  /// Installs the handlers, for the rest of the process. Without frames they only report the signal.
  static void install();

  /// Sets the modes that a dying process restores on its standard input; null: none.
  static void keep(const termios* of_terminal) noexcept;

 private:
  std::vector<LastWords> buses_;
};

/// A stack for signal handlers of the constructing thread, needed if the thread's own stack overflows. Out of
/// memory, handlers run on the thread's own stack.
class SignalStack {
 public:
  SignalStack() noexcept;
  ~SignalStack();
  SignalStack(const SignalStack&) = delete;
  SignalStack& operator=(const SignalStack&) = delete;

 private:
  std::unique_ptr<char[]> memory_;
};

/// Guards every write to a bus: once the last frames are being written, no other write begins.
class BusWrite {
 public:
  BusWrite() noexcept { writing_.fetch_add(1); }
  ~BusWrite() { writing_.fetch_sub(1); }
  BusWrite(const BusWrite&) = delete;
  BusWrite& operator=(const BusWrite&) = delete;

  bool allowed() const noexcept { return !ended_.load(); }

  /// For the last resort: forbids further writes. Returns false if they were forbidden already.
  static bool end() noexcept { return !ended_.exchange(true); }
  static bool none_is_going_on() noexcept { return writing_.load() == 0; }

 private:
  static inline std::atomic<int> writing_{0};
  static inline std::atomic<bool> ended_{false};
  static_assert(std::atomic<int>::is_always_lock_free && std::atomic<bool>::is_always_lock_free,
                "read in a signal handler");
};

enum class SignalFate : std::uint8_t {
  stop,         // a request: torque runs down, drives off, files complete, summary
  ignored,      // reported instead as the error of the write that caused it
  last_resort,  // a defect: see LastResort
};

struct SignalRow {
  int signal = 0;
  std::string_view name;  // "SIGINT"
  SignalFate fate = SignalFate::stop;
};

/// Lists every signal that can be caught and that ends or suspends a process by default. Real-time signals
/// have no names and are not listed; they have the fate `stop`.
std::span<const SignalRow> signal_rows() noexcept;

/// Protects the process to its end, for the verbs that command or simulate motors. A dead terminal, a pipe
/// without a reader and a limit on file sizes no longer end it, and a defect switches the motors off.
void guard_process();

/// Blocks the stop signals in the calling thread, so that other threads receive them. Deadly signals still
/// reach the last resort.
void block_stop_signals() noexcept;

/// Setup of every thread but the main one, from its start to its end.
/// It sets the name, the signals as by block_stop_signals(), and a stack for the last resort.
class ThreadSetup {
 public:
  /// name: at most 15 characters, as in `ps -T` and the table of docs/threads.md.
  explicit ThreadSetup(const char* name) noexcept;

 private:
  SignalStack stack_;
};

/// Policy for Ctrl-Z: a process that commands motors must not be suspended, because its drives would lose
/// their host.
enum class Suspension : std::uint8_t { allowed, stops };

/// Catches signals with the fate `stop` as long as this object exists. The first sets requested(), further
/// ones insisted(). The destructor restores the former handlers. A hang-up that was ignored already (nohup)
/// stays ignored. One at a time.
class StopSignals {
 public:
  explicit StopSignals(Suspension suspension = Suspension::allowed) noexcept;
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  const std::atomic<bool>& requested() const noexcept { return requested_; }
  const std::atomic<bool>& insisted() const noexcept { return insisted_; }
  /// Requests a stop from inside the program, as a signal would.
  void request() const noexcept { requested_ = true; }
  /// Requests a stop at once, as two signals would: see StopKey.
  void press_key() const noexcept {
    key_ = insisted_ = true;
    requested_ = true;
  }
  bool key_pressed() const noexcept { return key_; }
  /// Name of the first signal, "SIGINT", or of the key; empty if none came.
  std::string_view name() const noexcept;

  static constexpr std::size_t max_signals = 64;

 private:
  static void on_signal(int signal);

  static inline std::atomic<bool> requested_{false}, insisted_{false}, key_{false};
  static inline std::atomic<int> signal_{0};
  static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free,
                "set in a signal handler");
  struct sigaction former_[max_signals] {};  // former actions of the signals of signal_rows()
  bool caught_[max_signals]{};
};

}  // namespace godobject
