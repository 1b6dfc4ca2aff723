// A CAN bus on a pseudo-terminal: simulates an SLCAN adapter for the program that opens name().
// Such programs are SlcanBus, python-can's slcan interface and slcand of can-utils.
#pragma once

#include <string>
#include <vector>

#include "platform/linux/bus/bus.h"
#include "platform/linux/bus/slcan_line.h"

namespace godobject {

/// Is `down` until the other end opens its channel (O or L), and after it closes it (C). try_receive answers
/// commands. `sent` counts frames written to the terminal. Refuses time stamps, bit timing registers and
/// acceptance filters (Z, s, M, m), as an adapter may.
class PtyBus final : public LinuxBus {
 public:
  explicit PtyBus(const BusSettings& settings);
  ~PtyBus() override { close(); }

  /// Makes a pseudo-terminal, a new one each time.
  bool open() noexcept override;
  void close() noexcept override;
  SendResult try_send(const CanFrame& frame) noexcept override;
  bool try_receive(ReceivedFrame& out) noexcept override;
  BusState state() const noexcept override;
  BusCounters counters() const noexcept override { return counters_; }

  int descriptor() const noexcept override { return line_.port().descriptor(); }
  std::string trouble() const override;
  /// Path of the terminal for the other end; empty while closed.
  std::string name() const override;
  std::string as_written(const CanFrame& frame) const override;
  std::string slowness() const override { return line_.port().slowness(); }

 private:
  enum class Channel : std::uint8_t { closed, open, listening };

  bool handle(std::string_view line, ReceivedFrame& out) noexcept;
  bool receive(const CanFrame& frame, ReceivedFrame& out) noexcept;
  void answer(std::string_view text) noexcept;
  void open_channel(Channel channel) noexcept;
  void close_channel() noexcept;

  double bit_rate_;
  std::vector<CanFilter> filters_;
  SlcanLine line_{};
  int slave_fd_ = -1;  // kept open, because reading the master without an open slave is an error
  Channel channel_ = Channel::closed;
  double requested_bit_rate_ = 0;  // bit rate set by the other end; 0: not set
  BusCounters counters_{};
  std::string why_{};
};

}  // namespace godobject
