// Supervisor: the states of a device and of a run, with every transition, cause and output in one table.
// Rig and DevicePhases change their states by next() only. docs/faults.md shows the table.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/nonblocking.h"

namespace godobject {

enum class RigState : std::uint8_t {
  off,       // nothing is sent
  booting,   // waiting until every node is operational and every sensor has sent a sample
  homing,    // waiting for the user to confirm the home pose, if a sensor is incremental
  enabling,  // drives on their way to enabled, then settle_cycles there
  ready,     // everything works
  armed,     // torque follows command()
  hold,      // armed, without a pose of the hand: the last one is held
  fault,     // a fault bit is set
  stopping,  // the run ends; only drives with torque are commanded
  closing,   // drives disabled, nodes pre-operational; their frames are sent
  ended,
};
inline constexpr std::size_t num_rig_states = 11;

/// Cause of a transition. arm and restart are requests of the user; no other event leads to torque.
enum class RigEvent : std::uint8_t {
  start,
  nodes_up,
  homed,
  drives_up,
  arm,
  disarm,
  pose_lost,
  pose_back,
  fault,
  quick_stop,
  clear,
  stop,
  zero_reached,
  frames_sent,
  switch_off,
  restart,
};
inline constexpr std::size_t num_rig_events = 16;

/// Torque of the motors in a state.
enum class TorqueOutput : std::uint8_t {
  none,      // drives disabled or uncommanded
  run_down,  // falls to 0 within the drive's rate, and stays 0
  normal,    // follows the displayed force, within limit and rate
  fade,      // as normal; the displayed force falls to 0 within its rate
  at_once,   // each drive removes its torque by its own fastest means
};
inline constexpr std::size_t num_torque_outputs = 5;

std::string_view name_of(RigState state) noexcept;
std::string_view name_of(RigEvent event) noexcept;
std::string_view text_of(TorqueOutput torque) noexcept;

struct Supervision {
  RigState state = RigState::off;
  TorqueOutput torque = TorqueOutput::none;
  // state; in fault the one in which the first fault was raised. Devices that were up then are supervised.
  RigState reached = RigState::off;

  bool operator==(const Supervision&) const = default;
};

/// Set of states: bit 1 << state.
using RigStates = std::uint16_t;

struct RigTransition {
  RigStates from = 0;
  RigEvent event = RigEvent::start;
  RigState to = RigState::off;
  TorqueOutput torque = TorqueOutput::none;
  std::string_view cause;

  constexpr bool leaves(RigState state) const noexcept {
    return (from >> static_cast<unsigned>(state) & 1u) != 0;
  }
};

/// Returns the table. A state and an event have at most one row.
std::span<const RigTransition> rig_transitions() noexcept;

/// Returns the state after an event; none if the table has no row for it, and nothing changes. A torque that
/// was removed at once stays so until clear, or the end.
std::optional<Supervision> next(const Supervision& now, RigEvent event) noexcept GODOBJECT_NONBLOCKING;

/// Returns the table as Markdown, for docs/faults.md. Allocates.
std::string rig_transitions_markdown();

/// The state of one device or run.
class Supervisor {
 public:
  /// Returns false if the event changes nothing in this state.
  bool on(RigEvent event) noexcept GODOBJECT_NONBLOCKING {
    const std::optional<Supervision> after = next(now_, event);
    if (after) now_ = *after;
    return after.has_value();
  }
  RigState state() const noexcept { return now_.state; }
  TorqueOutput torque() const noexcept { return now_.torque; }
  RigState reached() const noexcept { return now_.reached; }

 private:
  Supervision now_;
};

}  // namespace godobject
