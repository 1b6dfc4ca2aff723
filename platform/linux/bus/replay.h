// A candump log as a bus: its frames arrive as far apart as they did when they were recorded.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "platform/linux/bus/bus.h"

namespace godobject {

/// "FILE" or "FILE,INTERFACE", as in the addresses of buses. A file's name may have a comma in it.
struct LogAddress {
  std::string path;
  std::string interface;  // empty: none is given
};
LogAddress parse_log_address(const std::string& where);

/// The log's first frame, of whichever interface, arrives when open() is called. What is sent is taken,
/// counted as sent, and goes nowhere. After the last frame the bus is `down` and trouble() says "end of the
/// log".
class ReplayBus final : public LinuxBus {
 public:
  /// where: path of a log, and after a comma the interface of it, which may be left out where the log has
  /// only one.
  ReplayBus(const std::string& where, const BusSettings& settings);
  ~ReplayBus() override { close(); }

  /// Reads and checks the whole log. False: trouble() names the line that is wrong.
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
  std::string log_{};  // its text: parsed line by line as time goes on, since that is the smallest form
  std::size_t position_ = 0;  // in log_, of the next line to be parsed
  ReceivedFrame next_{};      // on CLOCK_MONOTONIC
  bool has_next_ = false;
  bool is_cut_ = false;       // its last line
  Nanoseconds begin_ns_ = 0;  // time of the log's first frame
  Nanoseconds shift_ = 0;     // from the log's time to CLOCK_MONOTONIC
  int timer_fd_ = -1;
  BusState state_ = BusState::closed;
  BusCounters counters_{};
  std::string why_{};
};

}  // namespace godobject
