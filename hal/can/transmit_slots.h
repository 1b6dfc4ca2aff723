// What is to be sent when a bus takes no more: the newest command of each cycle, and a short queue for the rest.
#pragma once

#include <array>

#include "hal/base/fixed_queue.h"
#include "hal/can/bus.h"

namespace godobject {

struct TransmitCounters {
  std::uint64_t replaced = 0;   // a newer frame with its identifier came while it waited
  std::uint64_t expired = 0;    // waited longer than it was good for
  std::uint64_t abandoned = 0;  // waited while the bus went off, down or was closed
  std::uint64_t retried = 0;    // waited, and left

  std::uint64_t dropped() const noexcept { return replaced + expired + abandoned; }
};

/// A bus in front of another. Frames go straight through as long as it takes them. When it is full:
/// - a frame with the identifier of a slot (cyclic ones: SYNC, drive commands) waits in its slot, and a newer one takes
///   its place: a command of the last cycle is never sent after that of this one;
/// - any other frame (NMT, SDO) waits in a queue, in order, and try_send answers full when that is full as well.
/// Whatever waits is offered to the bus again at each later call, the queue first, then the slots in the order they
/// were added, and is dropped when its time is over or the bus is cut off.
class PacedCanBus final : public CanBus {
 public:
  static constexpr std::size_t max_slots = 32;
  static constexpr std::size_t queue_capacity = 16;

  /// `bus` outlives this. queue_lifetime: how long frames without a slot are worth sending.
  explicit PacedCanBus(CanBus& bus, Nanoseconds queue_lifetime = 100'000'000) noexcept
      : bus_(bus), queue_lifetime_(queue_lifetime) {}

  /// At set-up. A standard identifier, and how long after its try_send such a frame is worth sending: a cycle at most
  /// for a command. False: no slot left, or it has one.
  [[nodiscard]] bool add_slot(std::uint32_t id, Nanoseconds lifetime) noexcept;

  /// The time, for the lifetimes; once per cycle. Offers what waits.
  void advance_to(Nanoseconds now) noexcept;

  [[nodiscard]] bool open() noexcept override { return bus_.open(); }
  void close() noexcept override;
  /// queued: it has left for the bus, or waits.
  [[nodiscard]] SendResult try_send(const CanFrame& frame) noexcept override;
  [[nodiscard]] bool try_receive(ReceivedFrame& out) noexcept override;
  BusState state() const noexcept override { return bus_.state(); }
  /// The bus's; send_refused and send_dropped as seen from here.
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
