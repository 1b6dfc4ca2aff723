// A program of the user as the device, in any language, on a local socket. It sends the poses of the hand and
// receives the wrench to display (docs/how-to/device-of-your-own.md).
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "platform/device/hand_device.h"
#include "platform/device/streamed_target.h"

namespace godobject {

// Packets on a socket of type SOCK_SEQPACKET: little-endian, without padding, world frame, SI units.

/// Pose of the hand, from the program.
struct PosePacket {
  static constexpr std::uint32_t magic_of_poses = 0x31534447;  // "GDS1"
  enum Flag : std::uint32_t { clutch_open = 1, button = 2, not_valid = 4 };

  std::uint32_t magic = magic_of_poses;
  std::uint32_t number = 0;  // greater than that of the sample before
  double t_s = 0;            // time of measurement on CLOCK_MONOTONIC
  std::array<double, 3> p_WD_m{};
  std::array<double, 4> q_WD_wxyz{1, 0, 0, 0};
  std::uint32_t flags = 0;
  std::uint32_t reserved = 0;
};
static_assert(sizeof(PosePacket) == 80);

/// Wrench on the hand about the origin of the device's pose, one in each period.
struct WrenchPacket {
  static constexpr std::uint32_t magic_of_wrenches = 0x31574447;  // "GDW1"
  enum Flag : std::uint32_t { live = 1 };

  std::uint32_t magic = magic_of_wrenches;
  std::uint32_t number = 0;  // number of the newest sample; 0: none yet
  double t_s = 0;            // time of the run
  std::array<double, 3> f_W_N{}, tau_W_Nm{};
  std::uint32_t flags = 0;  // live: cleared once the wrench stays zero, after trouble and at the end
  std::uint32_t reserved = 0;
};
static_assert(sizeof(WrenchPacket) == 72);

struct SocketDeviceCounters {
  bool connected = false;
  std::uint64_t samples = 0;    // used
  std::uint64_t malformed = 0;  // refused: size, magic, number, a value that is no pose, a time in the future
  std::uint64_t late = 0;       // ignored: older than stale_after_ns
  std::uint64_t connections = 0;
  std::uint64_t refused = 0;   // further programs, while one was connected
  std::uint64_t wrenches = 0;  // sent
  std::uint64_t not_sent = 0;  // wrenches that the program was too slow to receive
};

/// Serves the socket in the loop itself, without waiting. No function but open() allocates.
class SocketDevice final : public HandDevice {
 public:
  /// Age above which a sample is stale: the pose is then held, and the force fades.
  static constexpr Nanoseconds stale_after_ns = 50'000'000;
  /// Limits of the hand's motion, m/s and rad/s; motion beyond them is left out.
  static constexpr double max_speed = 2, max_turn_rate = 20;
  /// Time in which the wrench runs down at the end of a run, s.
  static constexpr double run_down_s = 0.05;
  /// Largest distance of the hand from the origin, m.
  static constexpr double max_distance = 100;

  /// scene: must have a driven body; the first one follows the program. clock: CLOCK_MONOTONIC.
  SocketDevice(const SceneConfig& scene, LoopClock clock);
  /// Sends a last wrench of zero and removes the socket.
  ~SocketDevice() override;
  SocketDevice(const SocketDevice&) = delete;
  SocketDevice& operator=(const SocketDevice&) = delete;

  /// Listens on a socket of this path. Returns why this failed; empty on success.
  std::string open(const std::string& path);

  void read(Period& period, std::span<BodySample> samples) noexcept override;
  void command(Period& period, std::span<const Wrench> F_hand_W, Shown& shown) noexcept override;
  void tell(RunTrouble) noexcept override { withheld_ = true; }
  bool has_hold_button() const noexcept override { return true; }
  bool hold_pressed() const noexcept override { return hold_pressed_; }
  bool makes_torque() const noexcept override { return program_ >= 0; }
  void disarm() noexcept override { run_down_left_s_ = run_down_s; }
  void quick_stop() noexcept override { run_down_left_s_ = 0; }
  bool run_down(Period& period) noexcept override;
  void stop(Period& period) noexcept override;
  void restart() override { withheld_ = false; }

  const std::string& path() const noexcept { return path_; }
  const SocketDeviceCounters& counters() const noexcept { return counters_; }

 private:
  void accept_program() noexcept;
  void receive() noexcept;
  void take(const PosePacket& sample) noexcept;
  void send(const WrenchPacket& wrench) noexcept;
  void disconnect() noexcept;

  std::size_t body_;  // body that follows the program
  LoopClock clock_;
  StreamedTarget stream_;
  StreamedSample newest_;
  std::string path_;
  int listener_ = -1, program_ = -1;
  std::uint32_t number_ = 0;  // number of the newest sample of this connection
  bool pressed_ = false;      // state of the button in the newest sample
  bool was_valid_ = false;    // true once a sample was valid
  bool hold_pressed_ = false;
  bool withheld_ = false;  // true after trouble, until restart(): every wrench is zero
  WrenchPacket shown_{};   // last wrench of the run
  double run_down_left_s_ = 0;
  SocketDeviceCounters counters_;
};

}  // namespace godobject
