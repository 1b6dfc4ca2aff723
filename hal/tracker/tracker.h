// Base of all trackers: bytes in, bytes out, and a report with the newest sample of every tool. A tracker is
// a slow, delayed source of poses with its own thread; an invisible tool is not a fault.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/math/types.h"
#include "hal/base/nanoseconds.h"
#include "hal/tracker/params.h"

namespace godobject {

enum class ToolState : std::uint8_t {
  unseen,         // nothing reported yet
  valid,          // the pose is that of the tool at t_ns
  missing,        // hidden or out of sight: uncover it
  disabled,       // not plugged in, or its definition was refused: see the report's text
  out_of_volume,  // seen outside the calibrated volume of the tracker: the pose is not reliable
  stale,          // no new sample for stale_after_s: see the tracker's state
};
const char* name(ToolState state) noexcept;

/// Newest sample of one tool. The pose is that of the last valid sample.
struct ToolSample {
  ToolState state = ToolState::unseen;
  Pose X_TH;                 // tool in the tracker's frame
  std::uint32_t frame = 0;   // measurement counter of the tracker; Liberty: ms
  std::uint32_t number = 0;  // number of valid samples; changes with each new measurement
  Nanoseconds t_ns = 0;      // measurement time as defined by each tracker
  double error_m = 0;        // residual of the tracker's own fit; 0 if not reported
};

enum class TrackerState : std::uint8_t {
  opening,       // waiting for the line: is the port there, has this user the right to open it?
  initialising,  // communicating, not measuring yet
  tracking,      // measuring
  failed,        // did not track in time; retried: see the text
};
const char* name(TrackerState state) noexcept;

/// Since the start of the program.
struct TrackerCounters {
  std::uint64_t samples = 0;      // new measurements of all tools
  std::uint64_t repeated = 0;     // repeated reports: the host polls faster than the tracker measures
  std::uint64_t lost_frames = 0;  // measurements not polled in time
  std::uint64_t bad_crc = 0;
  std::uint64_t malformed = 0;  // replies or records that violate the protocol
  std::uint64_t timeouts = 0;   // commands without a reply
  std::uint64_t restarts = 0;   // restarts after it was tracking
};

inline constexpr std::size_t max_tracked_tools = 8;

/// Complete state of a tracker at one time. Owns nothing: passed between threads by value.
struct TrackerReport {
  TrackerState state = TrackerState::opening;
  std::array<char, 160> text{};  // activity, or error and remedy; ends with a zero
  TrackerCounters counters;
  std::array<ToolSample, max_tracked_tools> tools{};  // in the order of TrackerParams::tools
};

/// Next action of the line.
struct LineRequest {
  enum class Kind : std::uint8_t { none, send, serial_break, set_baud, reopen };
  Kind kind = Kind::none;
  std::span<const std::uint8_t> bytes{};  // bytes to send; valid until the next call
  std::uint32_t baud = 0;
};

/// Interface of a protocol. A new protocol is one file that implements it, and one line in make_tracker(). No
/// call waits or allocates.
class Tracker {
 public:
  explicit Tracker(const TrackerParams& params);
  virtual ~Tracker() = default;
  Tracker(const Tracker&) = delete;
  Tracker& operator=(const Tracker&) = delete;

  /// Returns the bit rate at which the line is opened.
  virtual std::uint32_t first_baud() const noexcept = 0;
  /// Called when the line has just been opened: begins.
  virtual void opened(Nanoseconds now) noexcept = 0;
  /// Receives any bytes.
  virtual void receive(std::span<const std::uint8_t> bytes, Nanoseconds now) noexcept = 0;
  /// Returns the next action; called after every receive() and every few ms, until there is none.
  virtual LineRequest next(Nanoseconds now) noexcept = 0;

  /// Reports a missing or lost line. why: error of the operating system. too_long: true if the time to wait
  /// for the line is over; the tracker has then failed.
  void line_lost(const std::string& why, bool too_long, Nanoseconds now) noexcept;
  /// Marks samples that have become too old.
  void expire(Nanoseconds now) noexcept;
  const TrackerReport& report() const noexcept { return report_; }
  const TrackerParams& params() const noexcept { return params_; }

 protected:
  [[gnu::format(printf, 3, 4)]] void enter(TrackerState state, const char* format, ...) noexcept;
  /// Records a measurement of a tool. A frame equal to that of the previous sample is not new.
  void measured(std::size_t tool, const Pose& X_TH, std::uint32_t frame, double error_m, ToolState state,
                Nanoseconds t) noexcept;
  /// Records a report of a tool without a pose.
  void not_measured(std::size_t tool, ToolState state, Nanoseconds t) noexcept;

  TrackerParams params_;
  TrackerReport report_;
  Nanoseconds stale_after_ns_ = 0;
};

/// Bytes of each tool's definition file, in the order of TrackerParams::tools; empty for a tool without one.
using ToolDefinitions = std::vector<std::vector<std::uint8_t>>;

/// True if a tool is named by a definition file: for NDI, any name but the two digits of a port handle.
bool needs_definition(TrackerProtocol protocol, const std::string& tool);

struct MadeTracker {
  std::unique_ptr<Tracker> tracker;  // null: see errors
  std::vector<std::string> errors;
};
MadeTracker make_tracker(const TrackerParams& params, ToolDefinitions definitions);

}  // namespace godobject
