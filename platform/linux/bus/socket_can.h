// A CAN interface of Linux (SocketCAN): classic and FD, with the error frames of its driver and the kernel's
// receive stamps. Its configuration is checked. Kernel: Documentation/networking/can.rst.
#pragma once

#include <linux/can.h>
#include <net/if.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hal/base/stamp_clock.h"
#include "hal/can/error.h"
#include "hal/can/frame.h"
#include "platform/linux/bus/bus.h"

namespace godobject {

/// CAN frame in the layout of Linux's raw sockets. A classic frame is the beginning of this struct: same
/// layout, fewer bytes.
using KernelFrame = canfd_frame;

/// Returns the number of bytes of `out` for the kernel: CAN_MTU or CANFD_MTU. `frame` must be valid.
inline std::size_t to_kernel(const CanFrame& frame, KernelFrame& out) noexcept {
  out = {};
  out.can_id = frame.id | (frame.extended ? CAN_EFF_FLAG : 0u) | (frame.remote ? CAN_RTR_FLAG : 0u);
  out.len = frame.size;
  if (frame.bit_rate_switch) out.flags = CANFD_BRS;
  std::copy_n(frame.data.begin(), frame.size, out.data);
  return frame.fd ? CANFD_MTU : CAN_MTU;
}

/// Returns none if `size` is neither CAN_MTU nor CANFD_MTU, or the frame's length exceeds it.
inline std::optional<CanFrame> from_kernel(const KernelFrame& in, std::size_t size) noexcept {
  if (size != CAN_MTU && size != CANFD_MTU) return std::nullopt;
  CanFrame frame;
  frame.fd = size == CANFD_MTU;
  if (in.len > (frame.fd ? CANFD_MAX_DLEN : CAN_MAX_DLEN)) return std::nullopt;
  frame.extended = (in.can_id & CAN_EFF_FLAG) != 0;
  frame.id = in.can_id & (frame.extended ? CAN_EFF_MASK : CAN_SFF_MASK);
  frame.remote = !frame.fd && (in.can_id & CAN_RTR_FLAG) != 0;
  frame.bit_rate_switch = frame.fd && (in.flags & CANFD_BRS) != 0;
  frame.size = in.len;
  std::copy_n(in.data, in.len, frame.data.begin());
  return frame;
}

/// Enables the kernel's receive time stamps (SO_TIMESTAMPING). Returns false with errno on failure.
bool enable_receive_stamps(int socket) noexcept;

/// Converts receive stamps to CLOCK_MONOTONIC. The kernel stamps a frame by the wall clock when the driver
/// delivers it. It adds the controller's own stamp if there is one (raw hardware, on a clock of its own).
/// - Wall clock: both clocks are read together with the frame, and the frame's age by the wall clock is
/// subtracted from CLOCK_MONOTONIC. If the wall clock is set between arrival and reading, the result is the
/// time of reading.
/// - Controller: StampClock, against the time of arrival found as above.
class ReceiveStamp {
 public:
  /// Returns the time of arrival of a message read by recvmsg; never before that of the previous message.
  /// Without a stamp it is the time of reading.
  Nanoseconds of(const msghdr& message) noexcept;

 private:
  StampClock controller_;
  Nanoseconds last_ = 0;
};

/// Properties of an interface with a controller; a virtual one (vcan) has none.
struct CanController {
  std::uint32_t bit_rate = 0;       // bit/s; 0: not set
  std::uint32_t data_bit_rate = 0;  // bit/s; 0: classic
  std::uint32_t restart_ms = 0;     // 0: stays off after a bus-off
  BusState state = BusState::closed;
  std::uint16_t transmit_error_counter = 0;
  std::uint16_t receive_error_counter = 0;
};

/// Configuration of a CAN interface, as the kernel returns it over rtnetlink.
struct CanLink {
  bool up = false;
  std::uint32_t mtu = 0;  // 16: classic frames, 72: also FD
  std::uint32_t transmit_queue_length = 0;
  std::array<char, 16> qdisc{};  // queueing discipline, e.g. pfifo_fast
  std::optional<CanController> controller{};

  bool carries_fd() const noexcept { return mtu >= 72; }
};

/// Reads the configuration. Returns 0 or errno: ENODEV if the interface does not exist, EMEDIUMTYPE if it is
/// not a CAN interface. Does not allocate.
int read_can_link(const char* interface, CanLink& link) noexcept;

enum class LinkFit : std::uint8_t { fits, down, bit_rate, data_bit_rate, classic_only };

/// Returns the first conflict of `link` with the expected `settings`.
LinkFit fit(const CanLink& link, const BusSettings& settings) noexcept;

/// Returns the conflict and the commands that resolve it. Empty for LinkFit::fits.
std::string text_of(LinkFit fit, const std::string& interface, const CanLink& link,
                    const BusSettings& settings);

/// Returns why there is no CAN interface of this name, and the remedy; empty for other errors.
/// error: result of read_can_link().
std::string why_no_link(const std::string& interface, int error);
/// Returns the remedy of bus-off.
std::string bus_off_text(const std::string& interface, const CanLink& link);
/// Returns warnings of later trouble: no restart after bus-off, a queue that drops old frames. Empty if none.
std::string link_warnings(const std::string& interface, const CanLink& link);

/// Checks an interface for a run. Returns one step if all is well, otherwise one for each trouble.
/// error, link: result of read_can_link().
std::vector<RtStep> check_can_link(const BusCheck& bus, int error, const CanLink& link);

/// A bus on a CAN interface. The filters work in the kernel, also on own frames. They must pass the
/// identifiers of own frames, so that BusCounters::sent counts them. An interface that goes down and up again
/// is reused automatically. One that was unplugged needs close() and open(), which looks it up by name.
class SocketCanBus final : public LinuxBus {
 public:
  SocketCanBus(const std::string& interface, const BusSettings& settings);
  ~SocketCanBus() override;
  SocketCanBus(const SocketCanBus&) = delete;
  SocketCanBus& operator=(const SocketCanBus&) = delete;

  /// Returns false if the interface is missing or down, or its bit rates differ from the expected ones.
  [[nodiscard]] bool open() noexcept override;
  /// Counters are kept.
  void close() noexcept override;
  [[nodiscard]] SendResult try_send(const CanFrame& frame) noexcept override;
  /// Returns false also after 64 error frames and own frames in a row; the descriptor stays readable.
  [[nodiscard]] bool try_receive(ReceivedFrame& out) noexcept override;
  BusState state() const noexcept override { return state_; }
  BusCounters counters() const noexcept override { return counters_; }

  int descriptor() const noexcept override { return fd_; }
  std::string trouble() const override;
  std::string name() const override { return interface_; }
  std::string as_written(const CanFrame& frame) const override;
  [[nodiscard]] bool observe(const FrameObserver& observer) noexcept override {
    observer_ = observer;
    return true;
  }

 private:
  struct Message;

  bool check_link() noexcept;
  bool set_options() noexcept;
  bool bind_to_interface() noexcept;
  bool fail(const char* what) noexcept;
  SendResult send_now(const CanFrame& frame) noexcept;
  SendResult refused(int error) noexcept;
  void lose_interface(int error) noexcept;
  bool is_up() const noexcept;
  std::string present_name() const;
  void count_overflow(std::uint32_t dropped_in_all) noexcept;
  bool read_message(Message& message) noexcept;
  bool take(const Message& message, ReceivedFrame& out) noexcept;
  void seen_alive() noexcept;
  std::string why_not_open() const;
  std::string why_state() const;
  BusSettings settings() const noexcept { return {bit_rate_, data_bit_rate_, {}}; }

  std::string interface_;
  unsigned index_ = 0;  // index of the interface that was opened last; renaming does not change it
  double bit_rate_ = 0;
  double data_bit_rate_ = 0;
  std::vector<can_filter> filters_;

  int fd_ = -1;
  bool carries_fd_ = false;
  BusState state_ = BusState::closed;
  BusCounters counters_;
  std::uint64_t queue_full_ = 0;      // try_send calls answered with full
  std::uint32_t dropped_in_all_ = 0;  // frames lost by this socket, as counted by the kernel (SO_RXQ_OVFL)
  ReceiveStamp stamp_;
  FrameObserver observer_;
  // Reason of the last failed open().
  const char* failed_call_ = nullptr;
  int failed_errno_ = 0;
  LinkFit fit_ = LinkFit::fits;
};

}  // namespace godobject
