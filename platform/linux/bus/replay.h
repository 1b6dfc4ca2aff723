// A candump log as a bus: frames arrive at the recorded intervals.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "platform/linux/bus/bus.h"

namespace godobject {

/// "FILE" or "FILE,INTERFACE", as in the addresses of buses. The name of a file may contain a comma.
struct LogAddress {
  std::string path;
  std::string interface;  // empty: not given
};
LogAddress parse_log_address(const std::string& where);

/// Replays a log. Its first frame, of any interface, arrives when open() is called. Sent frames are counted
/// as sent and discarded. After the last frame the bus is `down`, with "end of the log" in trouble().
class ReplayBus final : public LinuxBus {
 public:
  /// where: path of a log, optionally a comma and the interface; a log of one interface needs none.
  ReplayBus(const std::string& where, const BusSettings& settings);
  ~ReplayBus() override { close(); }

  /// Reads and checks the whole log. Returns false with the wrong line in trouble().
  bool open() noexcept override;
  void close() noexcept override;
  SendResult try_send(const CanFrame& frame) noexcept override;
  bool try_receive(ReceivedFrame& out) noexcept override;
  BusState state() const noexcept override { return state_; }
  BusCounters counters() const noexcept override { return counters_; }

  /// A timer that expires when the next frame is due.
  int descriptor() const noexcept override { return timer_fd_; }
  std::string trouble() const override;
  std::string name() const override { return path_; }

 private:
  bool fail(std::string why);
  bool check_log();
  bool take_next() noexcept;
  void arm() noexcept;

  std::string path_, interface_;
  std::vector<CanFilter> filters_;
  std::string log_{};         // text, parsed line by line during the replay because it is the smallest form
  std::size_t position_ = 0;  // position in log_ of the next line to be parsed
  ReceivedFrame next_{};      // next frame; its time is on CLOCK_MONOTONIC
  bool has_next_ = false;
  bool is_cut_ = false;       // true if the last line is cut off
  Nanoseconds begin_ns_ = 0;  // time of the log's first frame
  Nanoseconds shift_ = 0;     // offset from the log's time to CLOCK_MONOTONIC
  int timer_fd_ = -1;
  BusState state_ = BusState::closed;
  BusCounters counters_{};
  std::string why_{};
};

}  // namespace godobject
