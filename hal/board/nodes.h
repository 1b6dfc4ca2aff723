// An encoder board as a CANopen bus: each channel is a CiA 406 encoder, channel i at node i + 1. A rig
// therefore needs no code for boards. The bus delays frames as a wire of its bit rate does.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "hal/base/fixed_queue.h"
#include "hal/board/encoder_board.h"
#include "hal/canopen/canopen.h"

namespace godobject {

/// Behaviour of the nodes: NMT, heartbeats, and TPDO1 at every SYNC. They send boot-up messages at the
/// board's first frame and after each restart of its clock, which resets its counts. Other messages are
/// accepted and not answered, because the nodes have no objects. No call allocates.
///
/// A board samples at its own times, a CiA 406 encoder at the end of SYNC. The answer extrapolates the newest
/// frame to the end of SYNC with the speed between the last two frames, by the board's clock. At acceleration
/// a and age T the error is a T^2 / 2; without extrapolation it would be v T.
class BoardNodes {
 public:
  /// Age of the newest frame above which the board and its nodes are silent: no answers, no heartbeats, ns.
  /// The board must send at least 500 frames per second.
  static constexpr Nanoseconds silent_after = 5'000'000;
  static constexpr Nanoseconds heartbeat_period = 100'000'000;

  /// bit_rate: bit rate of the emulated wire, bit/s.
  explicit BoardNodes(double bit_rate) noexcept;

  /// Receives any bytes from the board.
  void receive(std::span<const std::uint8_t> bytes, Nanoseconds now) noexcept;
  /// Receives a frame from the host.
  void send(const CanFrame& frame, Nanoseconds now) noexcept;
  /// Returns the oldest frame to the host whose transmission has ended by `now`.
  [[nodiscard]] bool try_receive(ReceivedFrame& out, Nanoseconds now) noexcept;
  /// Returns the next time at which try_receive() has a frame, unless new input comes first; nullopt if none
  /// is queued.
  std::optional<Nanoseconds> next_due() const noexcept;

  bool silent(Nanoseconds now) const noexcept {
    return board_.counters().frames == 0 || now - t_arrival_ > silent_after;
  }
  const EncoderBoard& board() const noexcept { return board_; }
  /// Returns the number of frames dropped because the queue was full.
  std::uint64_t num_lost() const noexcept { return num_lost_; }

 private:
  void take(const EncoderFrame& before, bool restarted, Nanoseconds now) noexcept;
  void boot(Nanoseconds now) noexcept;
  void obey(const canopen::Nmt& nmt, Nanoseconds now) noexcept;
  void answer_sync(Nanoseconds now) noexcept;
  void put(const CanFrame& frame, Nanoseconds t) noexcept;
  std::uint32_t counts_at(std::size_t channel, Nanoseconds t) const noexcept;

  Nanoseconds sync_ns_, answer_ns_;  // durations on the wire
  EncoderBoard board_;
  std::array<double, max_board_counts> counts_per_ns_{};
  std::array<canopen::NmtState, max_board_counts> states_{};
  std::size_t num_nodes_ = 0;
  Nanoseconds t_arrival_ = 0;  // arrival of the newest frame
  Nanoseconds t_heartbeat_ = 0;
  FixedQueue<ReceivedFrame, 8 * max_board_counts> to_host_;
  Nanoseconds t_last_ = 0;  // due time of the last frame in to_host_
  std::uint64_t num_lost_ = 0;
};

}  // namespace godobject
