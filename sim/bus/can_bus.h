// Simulated CAN wire and its controllers: event driven, on a simulated clock.
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

/// Faults of one port, in addition to set_loss_probability and set_receive_delay. Shares are per frame.
struct PortFaults {
  double drop = 0;           // share of its sent and received frames that are lost
  double duplicate = 0;      // share of its sent and received frames that are duplicated
  double corrupt = 0;        // share of its sent frames destroyed on the wire: error frame, then sent again
  Nanoseconds delay_ns = 0;  // delay until it can read a received frame
};

/// One controller on a wire. Construct the wire first; neither may move afterwards. Frames are sent in the
/// order in which they were queued: a frame of high priority waits behind earlier frames of the same port.
class SimCanPort final : public CanBus {
 public:
  static constexpr std::size_t transmit_capacity = 16;
  static constexpr std::size_t receive_capacity = 64;

  explicit SimCanPort(SimCanWire& wire) noexcept;
  ~SimCanPort() override;
  SimCanPort(const SimCanPort&) = delete;
  SimCanPort& operator=(const SimCanPort&) = delete;

  /// Returns false if the wire already has SimCanWire::max_nodes ports.
  [[nodiscard]] bool open() noexcept override;
  /// Closes the port and drops both queues.
  void close() noexcept override;
  /// Queues a frame. If the wire is idle, the frame joins the arbitration of the next advance_to.
  [[nodiscard]] SendResult try_send(const CanFrame& frame) noexcept override;
  [[nodiscard]] bool try_receive(ReceivedFrame& out) noexcept override;
  BusState state() const noexcept override;
  BusCounters counters() const noexcept override;

  /// Starts the recovery from bus-off: after 128 sequences of 11 recessive bits the node is error active with
  /// an empty queue. Returns false if the node is not bus-off.
  bool restart() noexcept;
  /// Enters bus-off at once; no effect if closed or bus-off already.
  void force_bus_off() noexcept;
  /// Sets the delay of an automatic restart() after each later bus-off, ns; 0 (the default): never.
  void set_automatic_restart(Nanoseconds delay_ns) noexcept { restart_delay_ns_ = delay_ns; }

  /// Connects or disconnects the plug. A disconnected node receives no acknowledgement, repeats its frame and
  /// becomes error passive, but not bus-off. Disconnecting within a frame causes an error at the other nodes.
  void set_connected(bool connected) noexcept;
  /// Sets the share of frames that the receiver of this node misses. Such a frame was intact and
  /// acknowledged, so it is not repeated, like an overrun in a real controller.
  void set_loss_probability(double probability) noexcept { loss_probability_ = probability; }
  /// Sets the delay until a frame can be read, ns; its time stamp remains the end on the wire.
  void set_receive_delay(Nanoseconds delay_ns) noexcept { receive_delay_ns_ = delay_ns; }
  /// Gives the controller one buffer for each PDO of CANopen, as nodes have. A newer frame replaces a waiting
  /// one with its identifier.
  void set_pdo_buffers() noexcept { has_pdo_buffers_ = true; }
  void set_faults(const PortFaults& faults) noexcept { faults_ = faults; }
  /// Returns the number of frames lost by set_loss_probability and PortFaults::drop.
  std::uint64_t lost() const noexcept { return lost_; }

 private:
  friend class SimCanWire;

  struct Arrival {
    ReceivedFrame received;
    Nanoseconds t_readable_ns = 0;
  };
  struct Recovery {
    int sequences_left = 0;  // sequences of 11 recessive bits
    Nanoseconds t_start_ns = 0;
  };

  bool takes_part() const noexcept { return open_ && !errors_.is_bus_off(); }
  SendResult queue(const CanFrame& frame) noexcept;
  bool replace(const CanFrame& frame) noexcept;

  SimCanWire& wire_;
  std::size_t index_;  // index of this node on the wire; max_nodes: no place was free
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
  double corruption_probability = 0;  // per sent frame
  std::uint64_t seed = 1;
};

struct WireCounters {
  std::uint64_t frames = 0;  // completed
  std::uint64_t error_frames = 0;
  Nanoseconds busy_ns = 0;  // time of ended frames, error frames and intermissions
};

/// The wire. Model and simplifications:
/// - If the wire is idle, the head of every node's queue joins the arbitration, as in ISO 11898-1: lower
///   identifier first, data before remote, standard before extended with the same 11 bits.
/// - A frame lasts its own length (exact_bits). Receivers have it at the end of its end-of-frame field. Three
///   bits later the wire is idle. Answers queued by then join the arbitration at that instant.
/// - Every error of a frame is detected at its acknowledge slot, because damaged frames are not acknowledged.
///   Causes: no other node listens; the frame was corrupted for all nodes; two nodes sent the same identifier
///   with different contents. (Real controllers detect the last case at the first differing bit, up to one
///   frame earlier, and an error-passive one stops there. Here both continue until bus-off.) Equal frames
///   sent at the same time merge, as on a real wire.
/// - The error flag follows (6 bits, 7 if an error-active receiver adds its own), then delimiter and
///   intermission. The frame stays at the head of its queue. Sender: TEC + 8, except an error-passive one
///   without acknowledgement and without another flag (ISO 11898-1, exception of that rule).
///   Receivers: REC + 1.
/// - An error-passive sender waits 8 more bits before its next frame (suspend transmission).
/// - At bus-off the node's queue is dropped, because it is stale by the time the node recovers.
/// - No propagation delay, no clock tolerance, no overload frames.
/// The order of events depends only on the calls and the seed.
class SimCanWire {
 public:
  static constexpr std::size_t max_nodes = 32;

  explicit SimCanWire(const SimWireParams& params) noexcept;
  SimCanWire(const SimCanWire&) = delete;
  SimCanWire& operator=(const SimCanWire&) = delete;

  /// Runs all events up to and including time t; a time in the past has no effect.
  void advance_to(Nanoseconds t_ns) noexcept;
  /// Returns the time of the next event, now() for a frame that can start at once; nullopt if none is
  /// pending.
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

  /// Part of the wire: shared by all connected nodes, or the stub of one disconnected node.
  struct Segment {
    Phase phase = Phase::idle;
    Nanoseconds t_start_ns = 0;  // start of the frame
    Nanoseconds t_next_ns = 0;   // end of the phase; unused in idle
    Nanoseconds t_idle_ns = 0;   // time at which the wire last became idle
    NodeSet members = 0;
    NodeSet senders = 0;  // senders of the frame: several if arbitration tied
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
  /// Calls function(segment) for the shared wire and the stubs in use.
  template <class Self, class Function>
  static void for_each_segment(Self& self, Function&& function);
  void note_queue(const SimCanPort& node) noexcept;

  SimWireParams params_;
  SplitMix64 random_;
  FrameObserver observer_;
  Nanoseconds now_ns_ = 0;
  std::array<SimCanPort*, max_nodes> nodes_{};  // null: the place is free
  std::array<Segment, 1 + max_nodes> segments_;
  // Candidates for events, because next_event() runs many times per cycle.
  NodeSet sending_ = 0;  // nodes with a non-empty transmit queue
  NodeSet timed_ = 0;    // includes all nodes with a restart, a recovery or an unreadable received frame
  NodeSet stubs_ = 0;    // includes all stubs with a node or a frame on them
};

}  // namespace godobject
