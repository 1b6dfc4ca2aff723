// One period of a run for the view: copied out of the loop on request, and encoded as a frame. Frames and the
// messages of a page's pointer are binary, little-endian with a fixed layout (docs/view.md).
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/device/cues.h"
#include "hal/base/codec.h"
#include "hal/joint/kinematic_tree.h"
#include "platform/session/session.h"

namespace godobject {

// Copies out of the loop.

/// Latest value from one thread to another, on request: without a request the writer copies nothing.
/// Both ends are wait-free. The one slot belongs to the reader until its request, then to the writer until
/// give().
template <class T>
class Latest {
  static_assert(std::atomic<bool>::is_always_lock_free);

 public:
  /// like: any value; later ones have storage of the same size, so that assigning does not allocate.
  explicit Latest(const T& like) : value_(like) {}

  /// For the writer: true if the slot is the writer's and must be filled.
  bool wanted() const noexcept { return requested_.load(std::memory_order_acquire); }
  /// For the writer, until give().
  T& slot() noexcept { return value_; }
  void give() noexcept { requested_.store(false, std::memory_order_release); }

  /// For the reader: requests the next value. The result of get() belongs to the writer from here on.
  void ask() noexcept {
    any_ = true;
    requested_.store(true, std::memory_order_release);
  }
  /// For the reader: returns the requested value; null while there is none.
  const T* get() const noexcept {
    return any_ && !requested_.load(std::memory_order_acquire) ? &value_ : nullptr;
  }

 private:
  T value_;
  bool any_ = false;  // the reader's
  std::atomic<bool> requested_{false};
};

/// One period of a run, for the view.
struct ViewSample {
  CycleRecord record;
  RunPhase phase = RunPhase::off;
  bool missed_deadlines = false;  // latched
  RigCounters counters;
  Nanoseconds wake_ns = 0;            // longest wake-up latency since the previous sample
  double impact_speed = 0;            // fastest impact of a body since the previous sample, m/s
  std::uint32_t num_impacts = 0;      // contacts of bodies that began since then
  std::vector<ContactView> touching;  // storage for all contacts; the first num_touching are valid
  std::size_t num_touching = 0;
  bool paused = false;            // by a page: see ViewPace
  std::vector<Vec3> net_nodes{};  // positions of the nodes of all nets
  Nanoseconds t_ns = 0;           // time of the step, by MonotonicClock; 0: simulated
};

/// Speed of a run that a page pauses, steps or slows down. Both ends are wait-free. Only for runs without
/// hardware.
class ViewPace {
 public:
  static constexpr double unlimited = std::numeric_limits<double>::infinity();

  // For the view's thread:

  /// speed: simulated time per wall time; 0: paused; unlimited: as fast as the loop runs. steps: number of
  /// periods to run in the pause.
  void set(double speed, std::uint32_t steps) noexcept {
    steps_.fetch_add(steps, std::memory_order_relaxed);
    speed_.store(speed, std::memory_order_relaxed);
  }

  // For the loop:

  /// True if a period may run. now: time of the loop's clock, ns. step: period, ns.
  bool may_run(Nanoseconds now, Nanoseconds step) noexcept GODOBJECT_NONBLOCKING;
  bool is_limited() const noexcept { return speed_.load(std::memory_order_relaxed) != unlimited; }
  bool paused() const noexcept { return !(speed_.load(std::memory_order_relaxed) > 0); }

 private:
  std::atomic<double> speed_{unlimited};
  std::atomic<std::uint32_t> steps_{0};
  Nanoseconds due_ = 0;  // time of the next period of a slow run
};

/// Copies the record of a period out of the loop on request. The loop's end is real-time: the bodies' contact
/// events and one atomic load without a request, else a copy without allocation.
class ViewTap {
 public:
  /// paced: true if pages may pause the run.
  explicit ViewTap(const Session& session, bool paced = false)
      : latest_(like(session)), cues_(session.scene().bodies.size()), paced_(paced) {}

  /// For the loop, after each period. record: record of the last step so far. On real buses and trackers the
  /// sample has the time t_bus of the step. Otherwise it has none, because simulated time is no time of day.
  void offer(const Session& session, const CycleRecord& record) noexcept {
    observe_impacts(record);
    if (!latest_.wanted()) return;
    ViewSample& sample = latest_.slot();
    loop::copy(sample.record, record);
    const bool has_bus_time = session.bus() == BusChoice::real && record.t_bus_ns != 0;
    sample.t_ns = has_bus_time ? record.t_bus_ns : 0;
    sample.phase = session.phase();
    sample.missed_deadlines = session.missed_deadlines();
    sample.counters = session.rig_counters();
    sample.wake_ns = std::exchange(wake_ns_, 0);
    sample.impact_speed = std::exchange(impact_speed_, 0);
    sample.num_impacts = std::exchange(num_impacts_, 0);
    sample.paused = paced_ && pace_.paused();
    sample.num_touching = session.engine().contacts(sample.touching);
    session.engine().net_nodes(sample.net_nodes);
    latest_.give();
  }
  /// For the loop, before each period.
  void woke(Nanoseconds latency) noexcept { wake_ns_ = std::max(wake_ns_, latency); }

  /// For the loop: false while a page holds the run back. clock: read only then.
  template <class Clock>
  bool may_run(const Clock& clock, Nanoseconds step) noexcept {
    return !paced_ || !pace_.is_limited() || pace_.may_run(clock.now(), step);
  }

  /// For the loop: true if a page has reset the run, until restart().
  bool is_reset() const noexcept { return reset_.load(std::memory_order_relaxed); }

  /// Prepares the tap for another run of the same scene. Not while a loop runs.
  void restart() noexcept {
    std::ranges::fill(cues_, ContactCue{});
    reset_ = false;
  }

  /// For the view's thread: null if pages may not pause the run.
  ViewPace* pace() noexcept { return paced_ ? &pace_ : nullptr; }
  /// For the view's thread: ends the run, which is then started again. Only for runs without hardware.
  void reset() noexcept { reset_.store(true, std::memory_order_relaxed); }
  void ask() noexcept { latest_.ask(); }
  const ViewSample* get() const noexcept { return latest_.get(); }

 private:
  static ViewSample like(const Session& session) {
    ViewSample sample{.record = session.at_start(), .counters = {}, .touching = {}};
    sample.touching.resize(session.engine().composition().all_contacts());
    sample.net_nodes.resize(session.engine().nets().nodes.size());
    return sample;
  }

  void observe_impacts(const CycleRecord& record) noexcept {
    for (std::size_t i = 0; i < std::min(cues_.size(), record.bodies.size()); ++i) {
      const double speed = cues_[i].observe(record.bodies[i].contact_W, record.bodies[i].V_WB);
      if (speed < 0) continue;
      impact_speed_ = std::max(impact_speed_, speed);
      ++num_impacts_;
    }
  }

  Latest<ViewSample> latest_;
  std::vector<ContactCue> cues_;  // one per body
  double impact_speed_ = 0;
  std::uint32_t num_impacts_ = 0;
  ViewPace pace_;
  bool paced_;
  std::atomic<bool> reset_{false};
  Nanoseconds wake_ns_ = 0;
};

// Messages.

inline constexpr std::uint32_t frame_magic = 0x46564F47;    // "GOVF"
inline constexpr std::uint32_t pointer_magic = 0x50564F47;  // "GOVP"
inline constexpr std::uint32_t pace_magic = 0x43564F47;     // "GOVC"
inline constexpr std::uint32_t reset_magic = 0x52564F47;    // "GOVR"
inline constexpr std::uint16_t view_version = 1;
inline constexpr std::size_t frame_header_bytes = 132, frame_body_bytes = 28, frame_driven_bytes = 76,
                             frame_contact_bytes = 44, frame_vertex_bytes = 12, frame_value_bytes = 4,
                             pointer_bytes = 40;
/// Further contacts are counted and not sent.
inline constexpr std::size_t max_frame_contacts = 4096;

/// Bits of a frame's flags.
enum : std::uint8_t {
  frame_engaged = 1,
  frame_on_hold = 2,
  frame_oscillates = 4,
  frame_missed_deadlines = 8,
  frame_paused = 16
};

/// A number of a joint or drive that frames carry after the vertices.
struct ViewValue {
  std::string_view of;    // "joint" of the scene, "device" (joint), "term": spring, gear or closing joint
  std::size_t index = 0;  // among those of its kind
  std::string name;
  std::string_view unit;
};

/// Lists the values of a scene's frames, in their order.
std::vector<ViewValue> view_values(const SceneConfig& scene);

/// Indices of bodies that frames are made of.
struct ViewBodies {
  explicit ViewBodies(const SceneConfig& scene);
  std::vector<std::size_t> driven;
  std::vector<std::size_t> children;  // child of each joint
};

/// Encodes a frame into `out`, which it replaces. driven: indices of driven bodies. vertices: positions of
/// all moving surfaces' vertices, in their order, world, m. children: child of each joint.
void encode(const ViewSample& sample, std::span<const std::size_t> driven, std::span<const Vec3> vertices,
            std::vector<std::uint8_t>& out, std::span<const std::size_t> children = {});

/// Bits of a pointer's buttons.
enum : std::uint16_t { pointer_holds = 1, pointer_moves = 2 };

/// Message of a page's pointer, as a relative device.
struct PointerMessage {
  std::uint32_t number = 0;    // increases with each message of a connection
  bool holds = false;          // true while the pointer grips the body
  bool moves = false;          // true if the clutch is closed: the target moves with the pointer
  std::uint32_t target = 0;    // index of the driven body
  Vec3 dp_W = Vec3::Zero();    // displacement since the previous message, m
  Vec3 dphi_W = Vec3::Zero();  // rotation since then, rad
};
/// Limits on dp_W, m, and dphi_W, rad; messages beyond them are invalid.
inline constexpr double max_pointer_shift = 1, max_pointer_turn = 3.2;

ParseResult decode(std::span<const std::uint8_t> bytes, PointerMessage& out) noexcept;
std::array<std::uint8_t, pointer_bytes> encode(const PointerMessage& message) noexcept;

inline constexpr std::uint16_t joints_version = 2;
inline constexpr std::size_t joints_bytes = 16 + 4 * max_joints;

/// Displacements of the device's joints by a page: the pointer's message of version 2.
struct JointsMessage {
  std::uint32_t number = 0;      // increases with each message of a connection
  bool holds = false;            // true while the page moves the joints; other pages are refused meanwhile
  std::uint32_t num_joints = 0;  // number of the scene's `coordinates`
  // displacements since the previous message, rad or m; 0 beyond num_joints
  std::array<double, max_joints> dq{};
};
/// Largest displacement of a joint in a message, rad or m.
inline constexpr double max_joint_shift = 1;

ParseResult decode(std::span<const std::uint8_t> bytes, JointsMessage& out) noexcept;

inline constexpr std::size_t pace_bytes = 12;

/// Pause, steps and speed of a run, by a page.
struct PaceMessage {
  std::uint16_t steps = 0;             // periods to run in the pause
  double speed = ViewPace::unlimited;  // see ViewPace::set()
};
/// Limits of a message; others are invalid.
inline constexpr std::uint16_t max_pace_steps = 1000;
inline constexpr double max_pace_speed = 100;

ParseResult decode(std::span<const std::uint8_t> bytes, PaceMessage& out) noexcept;

inline constexpr std::size_t reset_bytes = 8;

/// Start of a run again, by a page.
struct ResetMessage {};

ParseResult decode(std::span<const std::uint8_t> bytes, ResetMessage& out) noexcept;
std::array<std::uint8_t, joints_bytes> encode(const JointsMessage& message) noexcept;

}  // namespace godobject
