#include "hal/rig/supervisor.h"

#include <array>

namespace godobject {
namespace {

using Torque = TorqueOutput;

constexpr RigStates set_of(auto... states) noexcept {
  return static_cast<RigStates>(((1u << static_cast<unsigned>(states)) | ...));
}

constexpr RigStates booting_to_fault =
    set_of(RigState::booting, RigState::homing, RigState::enabling, RigState::ready, RigState::armed,
           RigState::hold, RigState::fault);

constexpr std::array transitions = [] {
  using enum RigState;
  return std::array{
      RigTransition{set_of(off), RigEvent::start, booting, Torque::run_down, "request"},
      RigTransition{set_of(booting), RigEvent::nodes_up, homing, Torque::none,
                    "nodes operational, with samples"},
      RigTransition{set_of(homing), RigEvent::homed, enabling, Torque::run_down,
                    "home pose confirmed; at once without incremental sensors"},
      RigTransition{set_of(enabling), RigEvent::drives_up, ready, Torque::run_down,
                    "drives enabled for 10 cycles"},
      RigTransition{set_of(ready), RigEvent::arm, armed, Torque::normal, "request"},
      RigTransition{set_of(armed, hold), RigEvent::disarm, ready, Torque::run_down, "request"},
      RigTransition{set_of(armed), RigEvent::pose_lost, hold, Torque::fade,
                    "invalid sample, missed deadlines"},
      RigTransition{set_of(hold), RigEvent::pose_back, armed, Torque::normal, "valid again; by the ramp"},
      RigTransition{booting_to_fault, RigEvent::fault, fault, Torque::run_down, "any but `quick_stop`"},
      RigTransition{booting_to_fault, RigEvent::quick_stop, fault, Torque::at_once, "emergency stop"},
      RigTransition{set_of(stopping), RigEvent::quick_stop, stopping, Torque::at_once, "second signal"},
      RigTransition{set_of(fault), RigEvent::clear, booting, Torque::run_down, "request"},
      RigTransition{booting_to_fault, RigEvent::stop, stopping, Torque::run_down,
                    "signal, last cycle, failed boot, `--rearm auto`"},
      RigTransition{set_of(off), RigEvent::stop, ended, Torque::none, "request"},
      RigTransition{set_of(stopping), RigEvent::zero_reached, closing, Torque::none, "or after 2 s"},
      RigTransition{set_of(closing), RigEvent::frames_sent, ended, Torque::none, "10 periods"},
      RigTransition{booting_to_fault, RigEvent::switch_off, off, Torque::none, "the run closes"},
      RigTransition{set_of(ended), RigEvent::restart, off, Torque::none, "`--rearm auto`"},
  };
}();

constexpr std::array<std::string_view, num_rig_states> state_names{
    "off",  "booting", "homing",   "enabling", "ready", "armed",
    "hold", "fault",   "stopping", "closing",  "ended"};
constexpr std::array<std::string_view, num_rig_events> event_names{
    "start", "nodes_up",   "homed", "drives_up", "arm",          "disarm",      "pose_lost",  "pose_back",
    "fault", "quick_stop", "clear", "stop",      "zero_reached", "frames_sent", "switch_off", "restart"};
constexpr std::array<std::string_view, num_torque_outputs> torque_texts{"none", "runs down", "normal",
                                                                        "fades", "off at once"};

std::string names_of(const RigTransition& row) {
  if (row.from == booting_to_fault) return "booting to fault";
  std::string names;
  for (std::size_t i = 0; i < num_rig_states; ++i)
    if (row.leaves(static_cast<RigState>(i)))
      names += (names.empty() ? "" : ", ") + std::string(state_names[i]);
  return names;
}

}  // namespace

std::string_view name_of(RigState state) noexcept { return state_names[static_cast<std::size_t>(state)]; }
std::string_view name_of(RigEvent event) noexcept { return event_names[static_cast<std::size_t>(event)]; }
std::string_view text_of(TorqueOutput torque) noexcept {
  return torque_texts[static_cast<std::size_t>(torque)];
}

std::span<const RigTransition> rig_transitions() noexcept { return transitions; }

std::optional<Supervision> next(const Supervision& now, RigEvent event) noexcept {
  for (const RigTransition& row : transitions) {
    if (row.event != event || !row.leaves(now.state)) continue;
    Supervision after{.state = row.to, .torque = row.torque, .reached = row.to};
    if (row.to == RigState::fault) after.reached = now.reached;
    const bool stays_off = now.torque == Torque::at_once && event != RigEvent::clear;
    if (stays_off && row.torque == Torque::run_down) after.torque = Torque::at_once;
    return after;
  }
  return std::nullopt;
}

std::string rig_transitions_markdown() {
  std::string text = "| from | event | to | torque | cause |\n|---|---|---|---|---|\n";
  for (const RigTransition& row : transitions)
    text += "| " + names_of(row) + " | `" + std::string(name_of(row.event)) + "` | " +
            std::string(name_of(row.to)) + " | " + std::string(text_of(row.torque)) + " | " +
            std::string(row.cause) + " |\n";
  return text;
}

}  // namespace godobject
