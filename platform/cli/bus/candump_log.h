// A log of bus frames in candump's format.
#pragma once

#include <functional>
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
/// periods at most, and writes them. Not for the real-time thread.
class CandumpLog {
 public:
  /// buses: interface names, at most 15 characters.
  /// sink: takes text; false: not all of it got where it is to go.
  CandumpLog(std::function<bool(std::string_view)> sink, std::vector<std::string> buses);

  void add(const BusFrame& frame);
  /// Writes what is left. False when anything did not reach the sink.
  [[nodiscard]] bool close();

 private:
  void write_first(std::size_t count);

  std::function<bool(std::string_view)> sink_;
  std::vector<std::string> buses_;
  std::vector<BusFrame> waiting_;
  std::string buffer_;
  bool all_written_ = true;
};

}  // namespace godobject
