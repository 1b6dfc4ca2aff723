// A simulated CAN wire and the controllers on it, event driven on a simulated clock.
//
// The room: can_wire.cc and can_port.cc are its halves: arbitration and frame times, controllers and their queues;
// fault_confinement.h counts errors as ISO 11898-1 does; random.h.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "hal/base/fixed_queue.h"
#include "hal/can/bus.h"
#include "hal/can/timing.h"
#include "sim/bus/fault_confinement.h"
#include "sim/bus/random.h"

namespace godobject {

class SimCanWire;

/// Faults of one port, on top of what set_loss_probability and set_receive_delay make. Shares are per frame.
struct PortFaults {
  double drop = 0;           // of the frames it sends and of those it receives: they vanish
  double duplicate = 0;      // of both: they come twice
  double corrupt = 0;        // of those it sends: destroyed on the wire, error frame, sent again
  Nanoseconds delay_ns = 0;  // after which it can read what it has received
};

/// One controller on a wire. Place it and the wire at set-up, the wire first; neither moves afterwards.
/// Frames leave in the order they were queued: a frame of high priority waits behind its own elders.
class SimCanPort final : public CanBus {
 public:
  static constexpr std::size_t transmit_capacity = 16;
  static constexpr std::size_t receive_capacity = 64;

  explicit SimCanPort(SimCanWire& wire) noexcept;
  ~SimCanPort() override;
  SimCanPort(const SimCanPort&) = delete;
  SimCanPort& operator=(const SimCanPort&) = delete;

  /// False when the wire already has SimCanWire::max_nodes ports.
  [[nodiscard]] bool open() noexcept override;
  /// Drops both queues.
  void close() noexcept override;
  /// A frame queued while the wire is idle takes part in the arbitration of the next advance_to.
  [[nodiscard]] SendResult try_send(const CanFrame& frame) noexcept override;
  [[nodiscard]] bool try_receive(ReceivedFrame& out) noexcept override;
  BusState state() const noexcept override;
  BusCounters counters() const noexcept override;

  /// Starts the way out of bus-off: 128 sequences of 11 recessive bits later the node is error active with
  /// an empty queue. False when the node is not bus-off.
  bool restart() noexcept;
  /// Bus-off at once; nothing where it is closed or bus-off already.
  void force_bus_off() noexcept;
  /// restart() by itself so long after each later bus-off; 0 (the default): never.
  void set_automatic_restart(Nanoseconds delay_ns) noexcept { restart_delay_ns_ = delay_ns; }

  /// The plug. A disconnected node talks to itself: nobody acknowledges, so it repeats its frame and becomes
  /// error passive, but not bus-off. Pulling the plug in mid-frame leaves the others with an error.
  void set_connected(bool connected) noexcept;
  /// Share of the frames for this node that its receiver misses. The frame was fine on the wire and was
  /// acknowledged, so it is not repeated: what an overrun in a real controller does.
  void set_loss_probability(double probability) noexcept { loss_probability_ = probability; }
  /// How long after its end on the wire a frame can be read; its time stamp stays the end on the wire.
  void set_receive_delay(Nanoseconds delay_ns) noexcept { receive_delay_ns_ = delay_ns; }
  /// The controller has one buffer for each PDO of CANopen, as nodes have: a newer frame takes the place of one with its
  /// identifier that has not begun to leave.
  void set_pdo_buffers() noexcept { has_pdo_buffers_ = true; }
  void set_faults(const PortFaults& faults) noexcept { faults_ = faults; }
  /// Frames that set_loss_probability and PortFaults::drop took away.
  std::uint64_t lost() const noexcept { return lost_; }

 private:
  friend class SimCanWire;

  struct Arrival {
    ReceivedFrame received;
    Nanoseconds t_readable_ns = 0;
  };
  struct Recovery {
    int sequences_left = 0;  // of 11 recessive bits
    Nanoseconds t_start_ns = 0;
  };

  bool takes_part() const noexcept { return open_ && !errors_.is_bus_off(); }
  SendResult queue(const CanFrame& frame) noexcept;
  bool replace(const CanFrame& frame) noexcept;

  SimCanWire& wire_;
  std::size_t index_;  // of this node on the wire; max_nodes: no place was left
  bool open_ = false;
  bool connected_ = true;
  bool has_pdo_buffers_ = false;
  FixedQueue<CanFrame, transmit_capacity> transmit_queue_;
  FixedQueue<Arrival, receive_capacity> receive_queue_;
  FaultConfinement errors_;
  BusCounters counters_;
  Nanoseconds t_may_send_ns_ = 0;  // end of suspend transmission
  std::optional<Nanoseconds> t_restart_ns_;
  std::optional<Recovery> recovery_;

  double loss_probability_ = 0;
  Nanoseconds receive_delay_ns_ = 0;
  Nanoseconds restart_delay_ns_ = 0;
  PortFaults faults_;
  std::uint64_t lost_ = 0;
};

struct SimWireParams {
  BitRates rates{};
  double corruption_probability = 0;  // per frame sent
  std::uint64_t seed = 1;
};

struct WireCounters {
  std::uint64_t frames = 0;  // completed
  std::uint64_t error_frames = 0;
  Nanoseconds busy_ns = 0;  // frames, error frames and intermissions that have ended
};

/// The wire. What it models, and what it simplifies:
/// - When the wire is idle the head of every node's queue takes part in arbitration, bit for bit as in
///   ISO 11898-1: lower identifier first, data before remote, standard before extended with the same 11 bits.
/// - A frame lasts its own length (exact_bits). Receivers have it when its end-of-frame field ends; three
///   bits later the wire is idle. What they send in answer takes part in the arbitration at that instant.
/// - Whatever goes wrong with a frame is known at its acknowledge slot, because nobody acknowledges a damaged
///   frame: nobody else listens; the frame was corrupted on the wire, for everybody; or two nodes sent the
///   same identifier with different contents. (Real controllers see the last one at the first differing bit,
///   up to one frame earlier, and an error-passive one drops out there; here both go on until bus-off.)
///   Equal frames sent at the same time merge, as they do on a real wire.
/// - Then follow the error flag (6 bits, 7 when an error-active receiver joins in), delimiter, intermission;
///   the frame stays at the head of its queue. Sender: TEC + 8, except for an error-passive one whom
///   nobody acknowledged and who saw no other flag (ISO 11898-1, exception of that rule). Receivers: REC + 1.
/// - An error-passive sender waits 8 bits more before it sends again (suspend transmission).
/// - At bus-off the node's queue is dropped: what it held is stale by the time the node is back.
/// - No propagation delay, no clock tolerance, no overload frames.
/// The order of events is a function of the calls and of the seed.
class SimCanWire {
 public:
  static constexpr std::size_t max_nodes = 32;

  explicit SimCanWire(const SimWireParams& params) noexcept;
  SimCanWire(const SimCanWire&) = delete;
  SimCanWire& operator=(const SimCanWire&) = delete;

  /// Runs every event up to and including t; a time in the past does nothing.
  void advance_to(Nanoseconds t_ns) noexcept;
  /// Time of the next event, now() for a frame that can start at once; none when nothing is under way.
  std::optional<Nanoseconds> next_event() const noexcept;
  Nanoseconds now() const noexcept { return now_ns_; }

  void set_corruption_probability(double probability) noexcept {
    params_.corruption_probability = probability;
  }
  void set_observer(const FrameObserver& observer) noexcept { observer_ = observer; }
  const WireCounters& counters() const noexcept { return segments_[shared_segment].counters; }

 private:
  friend class SimCanPort;

  using NodeSet = std::uint32_t;  // bit i: node i
  static_assert(max_nodes <= 32);

  enum class Phase : std::uint8_t { idle, sending, ending, intermission };

  /// A piece of wire: the one all connected nodes share, or the stub of a disconnected node.
  struct Segment {
    Phase phase = Phase::idle;
    Nanoseconds t_start_ns = 0;  // of the frame
    Nanoseconds t_next_ns = 0;   // when the phase ends; not for idle
    Nanoseconds t_idle_ns = 0;   // when the wire last became idle
    NodeSet members = 0;
    NodeSet senders = 0;  // of the frame: more than one when arbitration tied
    NodeSet receivers = 0;
    bool collided = false;
    CanFrame frame;
    FrameBits bits;
    WireCounters counters;
  };
  static constexpr std::size_t shared_segment = 0;
  static constexpr std::size_t stub_segment(std::size_t node) noexcept { return 1 + node; }

  std::size_t attach(SimCanPort& port) noexcept;
  void detach(std::size_t node) noexcept;
  void join(std::size_t node, std::size_t segment) noexcept;
  void drop_out(std::size_t node) noexcept;

  void run_due_events() noexcept;
  void start_frame(Segment& segment) noexcept;
  void finish_sending(Segment& segment) noexcept;
  void fail_frame(Segment& segment) noexcept;
  void complete_frame(Segment& segment) noexcept;
  void become_idle(Segment& segment) noexcept;
  void begin_error_frame(Segment& segment, int bits_before_delimiter) noexcept;
  void deliver(SimCanPort& node, const ReceivedFrame& received) noexcept;
  void check_bus_off(SimCanPort& node) noexcept;
  void start_recovery(SimCanPort& node) noexcept;
  void count_idle_time(Segment& segment) noexcept;
  void finish_recovery(SimCanPort& node) noexcept;

  std::optional<Nanoseconds> next_event(const Segment& segment) const noexcept;
  std::optional<Nanoseconds> next_event(const SimCanPort& node) const noexcept;
  std::optional<Nanoseconds> recovery_time(const SimCanPort& node) const noexcept;
  bool any_error_active(NodeSet nodes) const noexcept;
  std::size_t segment_of(const SimCanPort& node) const noexcept;
  Nanoseconds bits_ns(int bits) const noexcept { return duration_ns(bits, params_.rates); }
  template <class Function>
  void for_each(NodeSet nodes, Function&& function) const;
  /// function(segment) of the shared wire and the stubs in use.
  template <class Self, class Function>
  static void for_each_segment(Self& self, Function&& function);
  void note_queue(const SimCanPort& node) noexcept;

  SimWireParams params_;
  SplitMix64 random_;
  FrameObserver observer_;
  Nanoseconds now_ns_ = 0;
  std::array<SimCanPort*, max_nodes> nodes_{};  // null: place is free
  std::array<Segment, 1 + max_nodes> segments_;
  // where an event can be: a wire is asked for its next one many times a cycle
  NodeSet sending_ = 0;  // nodes whose transmit queue is not empty
  NodeSet timed_ = 0;    // at least those with a restart, a recovery or a frame that they cannot read yet
  NodeSet stubs_ = 0;    // at least the stubs with a node or a frame on them
};

}  // namespace godobject
