// Emergency stop on the keyboard: the space bar of the terminal that is the standard input.
#pragma once

#include <termios.h>

#include <thread>

#include "platform/rt/signals.h"

namespace godobject {

/// Reads keys in a thread of its own as long as this object exists; the space bar is an emergency stop. The
/// terminal meanwhile passes on each key at once and does not show it. The destructor, or the last resort,
/// restores its modes.
class StopKey {
 public:
  /// Does nothing unless the standard input is a terminal in the foreground that no other program reads by
  /// keys. signals: must outlive this object.
  explicit StopKey(const StopSignals& signals) noexcept;
  ~StopKey();
  StopKey(const StopKey&) = delete;
  StopKey& operator=(const StopKey&) = delete;

  /// True if the space bar stops the motors.
  bool works() const noexcept { return thread_.joinable(); }

 private:
  void read_keys() const noexcept;

  const StopSignals& signals_;
  termios former_{};  // modes of the terminal
  int end_ = -1;      // eventfd that ends the thread
  std::thread thread_;
};

}  // namespace godobject
