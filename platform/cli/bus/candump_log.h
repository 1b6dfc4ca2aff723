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

/// Frame and index of its bus.
struct BusFrame {
  std::size_t bus = 0;
  ReceivedFrame received;
};

/// Writes the frames of all buses sorted by time. Frames arrive at most a few periods out of order. add() and
/// close() are called by one thread, pass_on() by another; neither is the real-time thread.
class CandumpLog {
 public:
  /// sink: receives text; returns false if some of it was not written.
  /// buses: interface names, at most 15 characters.
  CandumpLog(std::function<bool(std::string_view)> sink, std::vector<std::string> buses);

  void add(const BusFrame& frame);
  /// Appends the frames older than the newest frame of two calls ago. Called ten times a second, all frames
  /// of those times have arrived by then. Does nothing while add() or close() runs.
  void pass_on(const std::function<void(std::string_view)>& append);
  /// Writes the remaining frames. Returns false if the sink failed at any time.
  [[nodiscard]] bool close();

 private:
  void sort();
  /// Formats and removes the first `count` frames.
  const std::string& take_first(std::size_t count);
  void write_first(std::size_t count);

  std::mutex mutex_;  // guards the members below
  std::function<bool(std::string_view)> sink_;
  std::vector<std::string> buses_;
  std::vector<BusFrame> waiting_;
  std::string buffer_;
  std::array<Nanoseconds, 2> newest_{};  // newest frame at each of the last two calls of pass_on()
  bool all_written_ = true;
};

}  // namespace godobject
