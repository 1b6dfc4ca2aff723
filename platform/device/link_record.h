// Inputs of a rig: the calls of its device and the results of its buses, in their order. A rig that gets
// equal inputs acts equally to the last bit, see RigReplay. Usual results are only counted: no frame to read,
// a frame that was queued, an unchanged state.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "hal/rig/link.h"
#include "hal/rig/supervisor.h"

namespace godobject {

/// Calls of a RigDevice.
enum class RigCall : std::uint8_t {
  boot,
  arm,
  read,
  command,
  commanded,  // after a command, so that its results are complete before its row
  trouble,
  disarm,
  quick_stop,
  run_down,
  stop,
  close,
  restart,
};
inline constexpr std::size_t num_rig_calls = 12;

/// Event between a rig and the program around it.
struct LinkEvent {
  enum class Kind : std::uint8_t { call, began, waited, received, refused, state, live };

  Kind kind{};
  std::uint8_t bus = 0;
  std::uint8_t value = 0;     // argument of the call; result, state or liveness of the bus
  RigCall call{};             // the next four: of a call
  RigState rig_state{};       // before the call
  std::uint32_t sent = 0;     // hash of all frames sent before the call
  std::uint32_t cycle = 0;    // of a command; 0 otherwise
  std::uint32_t results = 0;  // number of usual results since the event before
  Nanoseconds t_ns = 0;       // time that the cycle began, to which it waited, or of the received frame
  CanFrame frame{};           // received
};
inline constexpr std::uint8_t num_link_event_kinds = 7;

/// Receives events in the loop. push returns false if there is no room; the events up to RigCall::restart are
/// then left out.
struct LinkEventSink {
  bool (*push)(void* context, const LinkEvent& event) noexcept GODOBJECT_NONBLOCKING = nullptr;
  void* context = nullptr;
};

/// Hash of frames, in their order (FNV-1a).
class FrameHash {
 public:
  /// Begins with no frames.
  FrameHash() = default;
  /// Continues after the frames with this hash.
  explicit FrameHash(std::uint32_t hash) noexcept : hash_(hash) {}

  void add(std::size_t bus, const CanFrame& frame) noexcept {
    add(static_cast<std::uint8_t>(bus));
    for (int shift = 0; shift < 32; shift += 8) add(static_cast<std::uint8_t>(frame.id >> shift & 0xff));
    add(static_cast<std::uint8_t>(frame.extended | frame.remote << 1 | frame.fd << 2 |
                                  frame.bit_rate_switch << 3));
    for (const std::uint8_t byte : frame.bytes()) add(byte);
  }
  std::uint32_t value() const noexcept { return hash_; }

 private:
  void add(std::uint8_t byte) noexcept { hash_ = (hash_ ^ byte) * 16777619u; }
  std::uint32_t hash_ = 2166136261u;
};

/// Link of a rig whose calls and results can be recorded. Forwards all calls.
class RecordedLink final : public RigLink {
 public:
  explicit RecordedLink(std::unique_ptr<RigLink> link) : link_(std::move(link)) {
    for (CanBus* const bus : link_->buses())
      buses_.push_back(std::make_unique<RecordedBus>(*this, *bus, buses_.size()));
    for (const std::unique_ptr<RecordedBus>& bus : buses_) ports_.push_back(bus.get());
  }

  /// Sends events to this sink from now on. Call it before the first call of the rig.
  void record(const LinkEventSink& sink) noexcept { sink_ = sink; }
  /// Records a call of the device before it is made.
  void call(RigCall call, RigState state, std::uint8_t argument = 0,
            std::uint32_t cycle = 0) noexcept GODOBJECT_NONBLOCKING {
    if (sink_.push == nullptr) return;
    if (call == RigCall::restart) begin_again();
    push({.kind = LinkEvent::Kind::call,
          .value = argument,
          .call = call,
          .rig_state = state,
          .sent = sent_.value(),
          .cycle = cycle});
  }

  std::span<CanBus* const> buses() noexcept override { return ports_; }
  std::span<CanBus* const> ports() const noexcept { return ports_; }
  Nanoseconds begin_cycle(double motion_time) noexcept override {
    const Nanoseconds t = link_->begin_cycle(motion_time);
    push({.kind = LinkEvent::Kind::began, .t_ns = t});
    return t;
  }
  Nanoseconds wait(Nanoseconds until) noexcept override {
    const Nanoseconds t = link_->wait(until);
    push({.kind = LinkEvent::Kind::waited, .t_ns = t});
    return t;
  }
  void end_cycle() noexcept override { link_->end_cycle(); }
  void set_observer(const BusObserver& observer) noexcept override { link_->set_observer(observer); }

 private:
  class RecordedBus final : public CanBus {
   public:
    RecordedBus(RecordedLink& link, CanBus& bus, std::size_t index) : link_(link), bus_(bus), index_(index) {}

    bool open() noexcept override { return bus_.open(); }
    void close() noexcept override { bus_.close(); }
    SendResult try_send(const CanFrame& frame) noexcept override {
      const SendResult result = bus_.try_send(frame);
      link_.sent_.add(index_, frame);
      if (result == SendResult::queued) ++link_.results_;
      else note(LinkEvent::Kind::refused, static_cast<std::uint8_t>(result));
      return result;
    }
    bool try_receive(ReceivedFrame& out) noexcept override {
      const bool has_frame = bus_.try_receive(out);
      if (!has_frame) ++link_.results_;
      else
        link_.push({.kind = LinkEvent::Kind::received,
                    .bus = static_cast<std::uint8_t>(index_),
                    .t_ns = out.t_ns,
                    .frame = out.frame});
      return has_frame;
    }
    BusState state() const noexcept override {
      const BusState now = bus_.state();
      if (now == state_) ++link_.results_;
      else note(LinkEvent::Kind::state, static_cast<std::uint8_t>(state_ = now));
      return now;
    }
    BusCounters counters() const noexcept override { return bus_.counters(); }
    bool is_live() const noexcept override {
      const bool now = bus_.is_live();
      if (now == is_live_) ++link_.results_;
      else note(LinkEvent::Kind::live, is_live_ = now);
      return now;
    }
    void begin_again() noexcept {
      state_ = BusState::error_active;
      is_live_ = true;
    }

   private:
    void note(LinkEvent::Kind kind, std::uint8_t value) const noexcept {
      link_.push({.kind = kind, .bus = static_cast<std::uint8_t>(index_), .value = value});
    }

    RecordedLink& link_;
    CanBus& bus_;
    std::size_t index_;
    mutable BusState state_ = BusState::error_active;  // latest recorded
    mutable bool is_live_ = true;                      // likewise
  };

  void begin_again() noexcept {
    sent_ = {};
    results_ = 0;
    has_gap_ = false;
    for (const std::unique_ptr<RecordedBus>& bus : buses_) bus->begin_again();
  }
  void push(LinkEvent event) noexcept {
    if (sink_.push == nullptr || has_gap_) return;
    event.results = results_;
    results_ = 0;
    has_gap_ = !sink_.push(sink_.context, event);
  }

  std::unique_ptr<RigLink> link_;
  std::vector<std::unique_ptr<RecordedBus>> buses_;
  std::vector<CanBus*> ports_;
  LinkEventSink sink_;
  FrameHash sent_;
  std::uint32_t results_ = 0;  // usual ones since the latest event
  bool has_gap_ = false;       // true after an event without room
};

}  // namespace godobject
