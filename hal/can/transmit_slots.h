// Buffers frames while a bus accepts no more: the newest command of each cycle, and a short queue for the
// rest.
#pragma once

#include <array>

#include "hal/base/fixed_queue.h"
#include "hal/can/bus.h"

namespace godobject {

struct TransmitCounters {
  std::uint64_t replaced = 0;   // replaced by a newer frame with the same identifier while waiting
  std::uint64_t expired = 0;    // waited longer than its lifetime
  std::uint64_t abandoned = 0;  // waiting when the bus went off, down or was closed
  std::uint64_t retried = 0;    // sent after waiting

  std::uint64_t dropped() const noexcept { return replaced + expired + abandoned; }
};

/// A bus in front of another. Frames pass straight through as long as the bus accepts them. If it is full:
/// - A frame with the identifier of a slot (cyclic frames: SYNC, drive commands) waits in its slot, and a
///   newer one replaces it. A command of the last cycle is thus never sent after that of this cycle.
/// - Any other frame (NMT, SDO) waits in a queue, in order; try_send returns full if that is full as well.
/// Waiting frames are offered to the bus again at each later call: the queue first, then the slots in the
/// order of add_slot(). They are dropped when their lifetime is over or the bus is cut off.
class PacedCanBus final : public CanBus {
 public:
  static constexpr std::size_t max_slots = 32;
  static constexpr std::size_t queue_capacity = 16;

  /// bus: underlying bus, outlives this. queue_lifetime: lifetime of frames without a slot, ns.
  explicit PacedCanBus(CanBus& bus, Nanoseconds queue_lifetime = 100'000'000) noexcept
      : bus_(bus), queue_lifetime_(queue_lifetime) {}

  /// Adds a slot, at set-up. id: standard identifier. lifetime: time after try_send until such a frame is
  /// dropped, ns, at most one cycle for a command. Returns false if no slot is free or the identifier has
  /// one.
  [[nodiscard]] bool add_slot(std::uint32_t id, Nanoseconds lifetime) noexcept;

  /// Sets the time from which lifetimes are counted, once per cycle, and offers waiting frames.
  void advance_to(Nanoseconds now) noexcept;

  [[nodiscard]] bool open() noexcept override { return bus_.open(); }
  void close() noexcept override;
  /// Sends a frame. Returns queued if the bus accepted it or it waits here.
  [[nodiscard]] SendResult try_send(const CanFrame& frame) noexcept override;
  [[nodiscard]] bool try_receive(ReceivedFrame& out) noexcept override;
  BusState state() const noexcept override { return bus_.state(); }
  /// Counters of the bus, with send_refused and send_dropped as counted here.
  BusCounters counters() const noexcept override;

  std::size_t waiting() const noexcept { return waiting_in_slots_ + queue_.size(); }
  const TransmitCounters& transmit_counters() const noexcept { return transmit_; }

 private:
  struct Waiting {
    CanFrame frame;
    Nanoseconds t_expiry = 0;
  };
  struct Slot {
    std::uint32_t id = 0;
    Nanoseconds lifetime = 0;
    bool occupied = false;
    Waiting waiting;
  };
  enum class Offer : std::uint8_t { gone, stays };

  Slot* slot_of(const CanFrame& frame) noexcept;
  bool store(const CanFrame& frame) noexcept;
  void offer_waiting() noexcept;
  Offer offer(const Waiting& waiting) noexcept;
  void abandon() noexcept;
  SendResult send(const CanFrame& frame) noexcept;

  CanBus& bus_;
  Nanoseconds queue_lifetime_;
  Nanoseconds now_ = 0;
  std::array<Slot, max_slots> slots_{};
  std::size_t num_slots_ = 0;
  std::size_t waiting_in_slots_ = 0;
  FixedQueue<Waiting, queue_capacity> queue_;
  TransmitCounters transmit_;
  std::uint64_t refused_ = 0;
};

}  // namespace godobject
