// What all trackers share: bytes come in, bytes go out, and the newest sample of every tool stands in a report. A tracker
// is a slow, late source of poses; it has a thread of its own, and a tool that it does not see is not a fault.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/math/types.h"
#include "hal/can/frame.h"
#include "hal/tracker/params.h"

namespace godobject {

enum class ToolState : std::uint8_t {
  unseen,         // nothing was reported yet
  valid,          // the pose is that of the tool at t_ns
  missing,        // hidden or out of sight: uncover it
  disabled,       // not plugged in, or its definition was refused: see the report's text
  out_of_volume,  // seen outside the volume the tracker is calibrated for: the pose is not to be relied on
  stale,          // nothing new for stale_after_s: see the tracker's state
};
const char* name(ToolState state) noexcept;

/// The newest sample of one tool. The pose stays that of the last valid one.
struct ToolSample {
  ToolState state = ToolState::unseen;
  Pose X_TH;                 // the tool in the tracker's frame
  std::uint32_t frame = 0;   // the tracker's own count of its measurements; Liberty: ms
  std::uint32_t number = 0;  // how many valid ones there were: another number is another measurement
  Nanoseconds t_ns = 0;      // when it was measured, as far as the protocol tells: see each tracker
  double error_m = 0;        // residual of the tracker's own fit; 0 where it gives none
};

enum class TrackerState : std::uint8_t {
  opening,       // waiting for the line: is the port there, has this user the right to open it?
  initialising,  // talking, not measuring yet
  tracking,      // measuring
  failed,        // did not get to tracking in time; it is tried again: the text says what to do
};
const char* name(TrackerState state) noexcept;

/// Since the start of the program.
struct TrackerCounters {
  std::uint64_t samples = 0;      // new measurements of all tools
  std::uint64_t repeated = 0;     // reported again: the host asks faster than the tracker measures
  std::uint64_t lost_frames = 0;  // measurements that nobody asked for in time
  std::uint64_t bad_crc = 0;
  std::uint64_t malformed = 0;  // replies or records that are not what the protocol says
  std::uint64_t timeouts = 0;   // commands without a reply
  std::uint64_t restarts = 0;   // times it had to begin anew after it was tracking
};

inline constexpr std::size_t max_tracked_tools = 8;

/// Everything there is to know of a tracker, at one time. Owns nothing: it is handed from thread to thread by value.
struct TrackerReport {
  TrackerState state = TrackerState::opening;
  std::array<char, 160> text{};  // what it is doing, or what is wrong and what to do; ends with a zero
  TrackerCounters counters;
  std::array<ToolSample, max_tracked_tools> tools{};  // in the order of TrackerParams::tools
};

/// What the line is to do next.
struct LineRequest {
  enum class Kind : std::uint8_t { none, send, serial_break, set_baud };
  Kind kind = Kind::none;
  std::span<const std::uint8_t> bytes{};  // to send; valid until the next call
  std::uint32_t baud = 0;
};

/// One protocol is one file that implements this, and a line in make_tracker(). No call waits or allocates.
class Tracker {
 public:
  explicit Tracker(const TrackerParams& params);
  virtual ~Tracker() = default;
  Tracker(const Tracker&) = delete;
  Tracker& operator=(const Tracker&) = delete;

  /// bit/s at which the line is opened.
  virtual std::uint32_t first_baud() const noexcept = 0;
  /// The line has just been opened: begin.
  virtual void opened(Nanoseconds now) noexcept = 0;
  /// Any bytes.
  virtual void receive(std::span<const std::uint8_t> bytes, Nanoseconds now) noexcept = 0;
  /// Asked for after every receive() and every few milliseconds, until there is none.
  virtual LineRequest next(Nanoseconds now) noexcept = 0;

  /// The line is not there (any more). `why`: what the operating system says. `too_long`: nobody should go on waiting.
  void line_lost(const std::string& why, bool too_long, Nanoseconds now) noexcept;
  /// Marks samples that have become too old.
  void expire(Nanoseconds now) noexcept;
  const TrackerReport& report() const noexcept { return report_; }
  const TrackerParams& params() const noexcept { return params_; }

 protected:
  [[gnu::format(printf, 3, 4)]] void enter(TrackerState state, const char* format, ...) noexcept;
  /// A tool was measured. A frame that is that of the sample before is not new.
  void measured(std::size_t tool, const Pose& X_TH, std::uint32_t frame, double error_m, ToolState state,
                Nanoseconds t) noexcept;
  /// A tool was reported without a pose.
  void not_measured(std::size_t tool, ToolState state, Nanoseconds t) noexcept;

  TrackerParams params_;
  TrackerReport report_;
  Nanoseconds stale_after_ns_ = 0;
};

/// Bytes of each tool's definition file, in the order of TrackerParams::tools; empty where a tool has none.
using ToolDefinitions = std::vector<std::vector<std::uint8_t>>;

/// Whether a tool is named by a definition file: of NDI, everything but the two digits of a port handle.
bool needs_definition(TrackerProtocol protocol, const std::string& tool);

struct MadeTracker {
  std::unique_ptr<Tracker> tracker;  // null: see errors
  std::vector<std::string> errors;
};
MadeTracker make_tracker(const TrackerParams& params, ToolDefinitions definitions);

}  // namespace godobject
