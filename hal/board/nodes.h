// An encoder board as a CANopen bus: each of its channels is a CiA 406 encoder, channel i node i + 1, so that a rig
// needs to know nothing of boards. The bus takes the time that a wire of its bit rate would.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "hal/base/fixed_queue.h"
#include "hal/board/encoder_board.h"
#include "hal/canopen/canopen.h"

namespace godobject {

/// What the nodes do: boot-up message at the board's first frame, and again when its clock began anew (its counts did,
/// too); NMT; heartbeats; TPDO1 at every SYNC. Other messages are taken and not answered: there are no objects. No call
/// allocates.
///
/// A board samples when it likes, a CiA 406 encoder when SYNC ends. The answer is what the counts are then: the newest
/// frame carried on with the speed between the last two, by the board's clock. At an acceleration a and an age T that
/// is off by a T^2 / 2; the newest counts alone would be by v T.
class BoardNodes {
 public:
  /// A board without a frame for so long is silent, and so are its nodes: neither answers nor heartbeats. It has to
  /// send 500 frames a second at least.
  static constexpr Nanoseconds silent_after = 5'000'000;
  static constexpr Nanoseconds heartbeat_period = 100'000'000;

  /// bit/s of the wire that is played.
  explicit BoardNodes(double bit_rate) noexcept;

  /// From the board: any bytes.
  void receive(std::span<const std::uint8_t> bytes, Nanoseconds now) noexcept;
  /// From the host.
  void send(const CanFrame& frame, Nanoseconds now) noexcept;
  /// To the host: the oldest frame whose end on the wire has come.
  [[nodiscard]] bool try_receive(ReceivedFrame& out, Nanoseconds now) noexcept;
  /// When try_receive() has something, if nothing comes before; none: nothing is on its way.
  std::optional<Nanoseconds> next_due() const noexcept;

  bool silent(Nanoseconds now) const noexcept {
    return board_.counters().frames == 0 || now - t_arrival_ > silent_after;
  }
  const EncoderBoard& board() const noexcept { return board_; }
  /// Frames that found no room.
  std::uint64_t num_lost() const noexcept { return num_lost_; }

 private:
  void take(const EncoderFrame& before, bool restarted, Nanoseconds now) noexcept;
  void boot(Nanoseconds now) noexcept;
  void obey(const canopen::Nmt& nmt, Nanoseconds now) noexcept;
  void answer_sync(Nanoseconds now) noexcept;
  void put(const CanFrame& frame, Nanoseconds t) noexcept;
  std::uint32_t counts_at(std::size_t channel, Nanoseconds t) const noexcept;

  Nanoseconds sync_ns_, answer_ns_;  // on the wire
  EncoderBoard board_;
  std::array<double, max_board_counts> counts_per_ns_{};
  std::array<canopen::NmtState, max_board_counts> states_{};
  std::size_t num_nodes_ = 0;
  Nanoseconds t_arrival_ = 0;  // of the newest frame
  Nanoseconds t_heartbeat_ = 0;
  FixedQueue<ReceivedFrame, 8 * max_board_counts> to_host_;
  Nanoseconds t_last_ = 0;  // in to_host_
  std::uint64_t num_lost_ = 0;
};

}  // namespace godobject
