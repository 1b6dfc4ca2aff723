// Replay of a rig from an input log: the device of the recorded run, with the recorded results of its buses.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "platform/device/rig.h"
#include "platform/scene/scene.h"
#include "platform/session/record.h"

namespace godobject {

/// Buses that return recorded results. Events that are not those of the calls end the replay.
class ReplayedLink final : public RigLink {
 public:
  enum class End : std::uint8_t {
    none,
    missing,  // the events end, or some are missing
    other,    // the rig makes another call than the recorded one
  };

  explicit ReplayedLink(std::size_t num_buses);

  void add(const LinkEvent& event) { events_.push_back(event); }
  /// Marks that events are missing here.
  void add_gap() { events_.push_back({.kind = gap}); }
  /// Drops the events before the next restart of the rig. Returns false if there is none so far.
  bool skip_to_restart() noexcept;
  /// Returns the cycle of the next event if it is a command; none otherwise.
  std::optional<std::uint32_t> next_command() const noexcept;
  /// Takes the next call of the device. None if the next event is not a call.
  std::optional<LinkEvent> take_call() noexcept;
  /// Begins with a new rig, without frames sent.
  void begin_again() noexcept;

  End end() const noexcept { return end_; }
  std::uint32_t sent() const noexcept { return sent_.value(); }
  /// Continues as if the recorded frames with this hash had been sent.
  void take_sent(std::uint32_t hash) noexcept { sent_ = FrameHash(hash); }

  std::span<CanBus* const> buses() noexcept override { return ports_; }
  Nanoseconds begin_cycle(double motion_time) noexcept override;
  Nanoseconds wait(Nanoseconds until) noexcept override;
  void set_observer(const BusObserver&) noexcept override {}

 private:
  static constexpr auto gap = static_cast<LinkEvent::Kind>(num_link_event_kinds);

  class ReplayedBus final : public CanBus {
   public:
    ReplayedBus(ReplayedLink& link, std::uint8_t index) : link_(link), index_(index) {}
    bool open() noexcept override { return true; }
    void close() noexcept override {}
    SendResult try_send(const CanFrame& frame) noexcept override;
    bool try_receive(ReceivedFrame& out) noexcept override;
    BusState state() const noexcept override;
    BusCounters counters() const noexcept override { return {}; }
    bool is_live() const noexcept override;
    void begin_again() noexcept;

   private:
    ReplayedLink& link_;
    std::uint8_t index_;
    mutable BusState state_ = BusState::error_active;
    mutable bool is_live_ = true;
  };

  const LinkEvent* result(LinkEvent::Kind kind, std::uint8_t bus) noexcept;
  Nanoseconds time(LinkEvent::Kind kind, Nanoseconds otherwise) noexcept;

  std::vector<std::unique_ptr<ReplayedBus>> buses_;
  std::vector<CanBus*> ports_;
  std::deque<LinkEvent> events_;
  LinkEvent taken_;
  std::uint32_t results_ = 0;  // usual ones since the latest event
  Nanoseconds now_ = 0;
  FrameHash sent_;
  End end_ = End::none;
};

/// Repeats the calls of a rig's device, and compares states, faults, torques and sent frames.
class RigReplay {
 public:
  /// scene: with a rig, outliving this object. start: coordinates of the device's joints at the start of the
  /// motion.
  RigReplay(const SceneConfig& scene, std::span<const double> start);

  /// Returns why the scene has no rig that can be replayed; empty if it has.
  static std::string why_not(const SceneConfig& scene, std::span<const double> start);

  /// Adds the next events of the log. first: number of the first one.
  void add(std::uint64_t first, std::span<const LinkEvent> events);
  /// Repeats the calls up to the command of this row. Returns the first difference, with both values; empty
  /// if there is none, or if inputs are missing. compares: false if only another order of the calls is one.
  std::string step(const CycleRecord& row, bool compares = true);
  /// Repeats the calls after the last row. Returns as step() does.
  std::string end();
  /// True if the log has events of a rig.
  bool has_events() const noexcept { return next_event_ > 0; }
  /// True if the log begins after the first event.
  bool begins_later() const noexcept { return begins_later_; }
  /// Number of rows that were repeated.
  std::uint64_t num_rows() const noexcept { return num_rows_; }
  /// Cycle of the first row that could not be repeated, because inputs are missing; empty if there is none.
  std::optional<std::uint64_t> first_missing() const noexcept { return first_missing_; }

 private:
  std::string repeat(const LinkEvent& call, const CycleRecord* row, bool compares);
  std::string compare(const LinkEvent& call) const;
  std::string compare(const CycleRecord& row) const;
  void command(const LinkEvent& call, const CycleRecord& row);

  const SceneConfig& scene_;
  std::vector<std::size_t> driven_;
  std::vector<BodySample> samples_;
  std::vector<Wrench> F_hand_W_;
  ReplayedLink* link_ = nullptr;  // owned by device_
  std::optional<RigDevice> device_;
  Period period_;
  bool is_lost_ = false;  // true while inputs are missing
  bool begins_later_ = false;
  std::uint64_t next_event_ = 0, num_rows_ = 0;
  std::optional<std::uint64_t> first_missing_;
};

}  // namespace godobject
