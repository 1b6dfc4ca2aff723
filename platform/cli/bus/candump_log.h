// A log of bus frames in candump's format.
#pragma once

#include <array>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "hal/can/candump.h"

namespace godobject {

/// A frame and the wire it was on.
struct BusFrame {
  std::size_t bus = 0;
  ReceivedFrame received;
};

/// Puts the frames of all buses in the order of their times, which differs from that of their coming by some
/// periods at most, and writes them. add() and close() in one thread, pass_on() in another; neither is the real-time one.
class CandumpLog {
 public:
  /// buses: interface names, at most 15 characters.
  /// sink: takes text; false: not all of it got where it is to go.
  CandumpLog(std::function<bool(std::string_view)> sink, std::vector<std::string> buses);

  void add(const BusFrame& frame);
  /// Appends the frames that were there two calls ago, and those of earlier times: called ten times a second it leaves none
  /// unwritten for long, and others of the same time have come. Nothing while add() or close() is at it.
  void pass_on(const std::function<void(std::string_view)>& append);
  /// Writes what is left. False when anything did not reach the sink.
  [[nodiscard]] bool close();

 private:
  void sort();
  /// The text of the first frames, which are then no longer there.
  const std::string& take_first(std::size_t count);
  void write_first(std::size_t count);

  std::mutex mutex_;  // of all below
  std::function<bool(std::string_view)> sink_;
  std::vector<std::string> buses_;
  std::vector<BusFrame> waiting_;
  std::string buffer_;
  std::array<Nanoseconds, 2> newest_{};  // of the frames that were there at the last two calls of pass_on()
  bool all_written_ = true;
};

}  // namespace godobject
