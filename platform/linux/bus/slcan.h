// A CAN bus behind an SLCAN adapter on a serial port, in user space, without a kernel driver. hal/can/slcan.h
// lists the limits of the protocol; docs/buses.md their consequences for a rig.
#pragma once

#include <string>
#include <vector>

#include "platform/linux/bus/bus.h"
#include "platform/linux/bus/slcan_line.h"

namespace godobject {

/// Counters: `sent` counts frames that the adapter acknowledged; 0 with an adapter that acknowledges none.
/// send_dropped: frames that it refused after they had been queued here. error_frames: garbled lines, and bus
/// errors in the adapter's flags.
class SlcanBus final : public LinuxBus {
 public:
  /// where: path of a serial port, optionally a comma and its baud rate, 115200 by default. USB adapters of
  /// the class CDC-ACM have no baud rate.
  SlcanBus(const std::string& where, const BusSettings& settings);
  ~SlcanBus() override { close(); }

  /// The only call that waits: for the adapter's answers, each at most answer_timeout.
  bool open() noexcept override;
  void close() noexcept override;
  SendResult try_send(const CanFrame& frame) noexcept override;
  bool try_receive(ReceivedFrame& out) noexcept override;
  BusState state() const noexcept override;
  BusCounters counters() const noexcept override;

  int descriptor() const noexcept override { return line_.port().descriptor(); }
  std::string trouble() const override;
  std::string name() const override { return path_; }
  std::string as_written(const CanFrame& frame) const override;
  std::string slowness() const override { return line_.port().slowness(); }
  const LineRest* line_rest() const noexcept override { return &line_.rest(); }
  const SerialPort& port() const noexcept { return line_.port(); }

  static constexpr Nanoseconds answer_timeout = 500'000'000;
  static constexpr Nanoseconds flags_period = 100'000'000;  // between two requests for the adapter's flags

 private:
  bool fail(std::string why);
  void wait_for_quiet();
  enum class Answer : std::uint8_t { none, ok, refused, flags };
  Answer ask(std::string_view command, Nanoseconds patience);
  Nanoseconds patience() const noexcept;
  std::string ask_version(const std::string& wanted);
  bool answers_version();
  bool command(std::string_view command, const std::string& what);
  bool handle(std::string_view line, ReceivedFrame& out) noexcept;
  void handle_flags(std::uint8_t flags) noexcept;
  void acknowledge(bool taken) noexcept;
  std::uint64_t num_garbled() const noexcept;

  std::string path_;
  std::uint32_t baud_ = 0;  // 0: the given text is not a number
  double bit_rate_, data_bit_rate_;
  std::vector<CanFilter> filters_;
  SlcanLine line_{};
  BusState state_ = BusState::closed;
  BusCounters counters_{};
  std::uint64_t num_unanswered_ = 0;   // frames sent and neither accepted nor refused yet
  std::uint64_t num_garbled_ = 0;      // lines that are not of the protocol
  std::uint64_t earlier_garbled_ = 0;  // garbled lines before the port was opened again
  std::uint64_t dropped_at_open_ = 0;  // lines of the reader that were dropped while the adapter was being
                                       // opened
  std::uint64_t num_fd_ = 0;           // CAN FD frames
  std::string version_{};              // answer to V of an adapter that acknowledges no commands; else empty
  bool has_flags_ = false;             // true if the adapter answers F (request of flags)
  bool reports_state_ = false;         // true for the dialect of Linux's driver, which reports more than F
  Nanoseconds flags_due_ = 0;
  std::string why_{};
};

}  // namespace godobject
