// Buses of a rig, replayed from logs: frames arrive at the times of the log, on a clock of their own. Frames
// that the rig sends are discarded.
#pragma once

#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "hal/canopen/canopen.h"
#include "hal/rig/link.h"
#include "hal/rig/params.h"

namespace godobject {

/// Log that contains the frames of one bus.
struct LogSource {
  std::string path;
  std::string interface;  // empty: the interface named as the bus, or the only one of the log
};

/// Replays logs as a RigLink. A cycle begins at each SYNC of the log, or at the host's heartbeat if SYNC was
/// left out. For a rig without CANopen it begins at the first request. After the last one, cycles follow at
/// the period. Frames of the host that wrote the log are left out, because a host does not receive its own
/// frames. Frames before its first cycle are left out too, because they configured the nodes. So are those
/// after its last command to leave Operational, because they belong to the end of its run.
class LogLink final : public RigLink {
 public:
  /// period: duration of a cycle without a SYNC, ns.
  LogLink(const RigParams& rig, Nanoseconds period);

  /// Reads the frames of each bus, once. Returns empty, or the error and its place.
  [[nodiscard]] std::string read(std::span<const LogSource> sources);
  /// True if no frame is left.
  bool ended() const noexcept { return now_ >= end_; }
  /// Returns how long the log's host was silent in all, ns: no cycle is run in such a gap.
  Nanoseconds skipped() const noexcept { return skipped_; }

  std::span<CanBus* const> buses() noexcept override { return ports_; }
  Nanoseconds begin_cycle(double motion_time) noexcept override;
  Nanoseconds wait(Nanoseconds until) noexcept override;
  void set_observer(const BusObserver& observer) noexcept override { observer_ = observer; }

 private:
  /// One bus, with its position in the log.
  class LoggedBus final : public CanBus {
   public:
    LoggedBus(const LogLink& log, std::size_t index) : log_(log), index_(index) {}
    bool open() noexcept override { return true; }
    void close() noexcept override {}
    SendResult try_send(const CanFrame& frame) noexcept override;
    bool try_receive(ReceivedFrame& out) noexcept override;
    BusState state() const noexcept override { return BusState::error_active; }
    BusCounters counters() const noexcept override { return counters_; }
    bool is_live() const noexcept override { return false; }

    void add(const ReceivedFrame& frame) { frames_.push_back(frame); }
    void end_at(Nanoseconds t) noexcept {
      while (!frames_.empty() && frames_.back().t_ns > t) frames_.pop_back();
    }
    void skip_to(Nanoseconds t) noexcept {
      while (next() < t) ++next_;
    }
    Nanoseconds next() const noexcept { return next_ < frames_.size() ? frames_[next_].t_ns : end_of_time; }

   private:
    const LogLink& log_;
    std::size_t index_;
    std::vector<ReceivedFrame> frames_;
    std::size_t next_ = 0;
    BusCounters counters_;
  };
  static constexpr Nanoseconds end_of_time = std::numeric_limits<Nanoseconds>::max();

  static constexpr Nanoseconds longest_gap = 10'000'000'000;  // a longer silence of the host is skipped

  std::string read_file(const std::string& path, std::span<const LogSource> sources);
  std::string choose(const std::string& path, std::span<const LogSource> sources,
                     const std::vector<std::string>& names, std::vector<std::size_t>& bus_of_name) const;
  void add(std::size_t bus, const ReceivedFrame& frame);
  void note_nmt(canopen::NmtCommand command, Nanoseconds t) noexcept;
  void add_cycles_without_sync();
  Nanoseconds wire_time(std::size_t bus, const CanFrame& frame) const noexcept;
  bool begins_cycle(std::size_t bus, const CanFrame& frame) const noexcept;
  bool is_of_host(std::size_t bus, const CanFrame& frame) const noexcept;

  RigParams rig_;
  Nanoseconds period_, now_ = 0, began_ = 0, end_ = 0;
  Nanoseconds shut_down_ = end_of_time;
  std::vector<std::unique_ptr<LoggedBus>> buses_;
  std::vector<CanBus*> ports_;
  bool has_canopen_ = false;
  std::vector<Nanoseconds> begins_;      // starts of cycles, on the bus of the first one
  std::vector<Nanoseconds> heartbeats_;  // heartbeats of the host that wrote the log, on that bus
  std::size_t first_bus_ = 0, next_begin_ = 0;
  Nanoseconds skipped_ = 0;
  BusObserver observer_;
};

}  // namespace godobject
