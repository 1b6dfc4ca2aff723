// godobject drive: commissions one CiA 402 drive by hand.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>

#include "hal/drive/cia402_text.h"
#include "platform/cli/command_line.h"
#include "platform/cli/drive/drive.h"
#include "platform/rt/cyclic.h"
#include "platform/rt/signals.h"

namespace godobject {
namespace {

using cia402::CommandKind;
using cia402::DriveState;

constexpr double limit_velocity_counts_per_s = 2000, limit_position_counts = 2000,
                 limit_torque_per_mille = 50;

struct DriveOptions {
  NodeOptions node;
  HomeOptions home;
  MoveOptions move;
  std::optional<double> velocity, position, torque, limit;
  double speed_limit = limit_velocity_counts_per_s;
  bool hand_on_the_stop = false;
};

std::string modes_text(std::int64_t supported_modes) {
  std::string text;
  for (int mode = 1; mode <= 32; ++mode)
    if (cia402::supports(static_cast<std::uint32_t>(supported_modes),
                         static_cast<cia402::OperationMode>(mode)))
      text += (text.empty() ? "" : ", ") + std::to_string(mode) + " " +
              name_of(static_cast<cia402::OperationMode>(mode));
  return text.empty() ? "none" : text;
}

/// Prints one line, with "-" for an object that the drive does not have. Returns false after printing an
/// error if there is no answer.
template <class Format>
bool print_object(NodeDialogue& node, const char* label, const TypedObject& object, const Format& format) {
  const std::optional<std::int64_t> value = node.read(object);
  if (!value && !node.was_absent()) {
    static_cast<void>(node.report());
    return false;
  }
  std::printf("%-16s %s\n", label, value ? format(*value).c_str() : "-");
  return true;
}

std::string state_text(std::int64_t statusword) {
  const auto word = static_cast<std::uint16_t>(statusword);
  std::string text = name_of(cia402::decode_state(word));
  if ((word & cia402::status_voltage_enabled) == 0) text += ", no supply of the power stage";
  if ((word & cia402::status_warning) != 0) text += ", warning";
  if ((word & cia402::status_internal_limit) != 0) text += ", at a limit";
  return text;
}

ExitCode print_status(const DriveOptions& options) {
  DriveDialogue drive(options.node);
  if (const ExitCode code = drive.open(); code != ExitCode::ok) return code;
  NodeDialogue& node = drive.node();
  const auto with_unit = [](const char* unit) {
    return [unit](std::int64_t value) { return std::to_string(value) + " " + unit; };
  };
  const auto mode = [](std::int64_t value) {
    return std::to_string(value) + " " + name_of(static_cast<cia402::OperationMode>(value));
  };
  namespace object = drive_object;
  const bool complete =
      print_object(node, "state", object::statusword, state_text) &&
      print_object(node, "mode", object::mode_display, mode) &&
      print_object(node, "error", object::error_code, error_code_text) &&
      print_object(node, "position", object::position, with_unit("counts")) &&
      print_object(node, "velocity", object::velocity, with_unit("counts/s")) &&
      print_object(node, "torque", object::torque, with_unit("per mille of the rated torque")) &&
      print_object(node, "rated torque", object::torque_rated,
                   with_unit("(6076h: mNm, or the maker's unit)")) &&
      print_object(node, "supported modes", object::supported_modes, modes_text) &&
      print_object(node, "quick stop", object::quick_stop_option, with_unit("(605Ah)"));
  if (complete && !node.host_seen().empty()) std::printf("%-16s %s\n", "host", node.host_seen().c_str());
  return complete ? ExitCode::ok : ExitCode::fault;
}

/// Waits for an accepted state of the drive, for at most `patience`. Returns none if there is no
/// answer.
template <class Wanted>
std::optional<DriveState> wait_for(DriveDialogue& drive, Nanoseconds patience, const Wanted& wanted) {
  constexpr Nanoseconds period_ns = 10'000'000;
  const Nanoseconds t_end_ns = MonotonicClock().now() + patience;
  for (;;) {
    const std::optional<DriveState> state = drive.state();
    if (!state || wanted(*state) || MonotonicClock().now() >= t_end_ns) return state;
    drive.node().wait(period_ns);
  }
}

/// Sends edges of bit 7 until the drive leaves Fault, each level long enough for a drive that samples it
/// rarely. Returns none if there is no answer.
std::optional<DriveState> send_reset_edges(DriveDialogue& drive, Nanoseconds patience_ns) {
  const auto reset = [](DriveState now) { return now != DriveState::fault; };
  const Nanoseconds t_end_ns = MonotonicClock().now() + patience_ns;
  std::optional<DriveState> state;
  for (std::uint16_t word = cia402::disable_voltage;; word = cia402::fault_reset_controlword(word)) {
    if (!drive.command(word)) return std::nullopt;
    state = wait_for(drive, cia402::fault_reset_hold_ns, reset);
    if (!state || reset(*state) || MonotonicClock().now() >= t_end_ns) break;
  }
  return drive.command(cia402::disable_voltage) ? state : std::nullopt;
}

ExitCode reset(const DriveOptions& options) {
  constexpr Nanoseconds patience_ns = 1'000'000'000;
  DriveDialogue drive(options.node);
  if (const ExitCode code = drive.open(); code != ExitCode::ok) return code;
  NodeDialogue& node = drive.node();
  std::optional<DriveState> state = drive.state();
  if (!state) return node.report();
  const bool was_in_fault = *state == DriveState::fault;
  if (was_in_fault) {
    state = send_reset_edges(drive, patience_ns);
    if (!state) return node.report();
  }
  const std::optional<std::int64_t> error = node.read(drive_object::error_code);
  if (!error) return node.report();
  const std::optional<std::int64_t> error_register = node.read(drive_object::error_register);
  if (!error_register) return node.report();
  const bool still = *state == DriveState::fault || *state == DriveState::fault_reaction_active;
  std::printf("%s: %s; %s; error register 1001h = %02Xh\n",
              still          ? "the fault remains, because its cause persists"
              : was_in_fault ? "reset"
                             : "nothing to reset",
              name_of(*state), error_code_text(*error).c_str(), static_cast<unsigned>(*error_register));
  return still ? ExitCode::fault : ExitCode::ok;
}

ExitCode quick_stop(const DriveOptions& options) {
  constexpr Nanoseconds patience_ns = 2'000'000'000;
  DriveDialogue drive(options.node);
  if (const ExitCode code = drive.open(); code != ExitCode::ok) return code;
  NodeDialogue& node = drive.node();
  if (!node.host_seen().empty())
    std::fprintf(stderr, "node %d: a host runs this bus (%s) and its next command overrides this one\n",
                 node.node(), node.host_seen().c_str());
  // Disable voltage is sent even if the quick stop was not answered.
  const bool taken = drive.command(cia402::quick_stop);
  if (!taken) static_cast<void>(node.report());
  const auto powered = [](DriveState state) {
    return state == DriveState::operation_enabled || state == DriveState::quick_stop_active;
  };
  if (taken) wait_for(drive, patience_ns, [&](DriveState state) { return !powered(state); });
  const bool released = drive.command(cia402::disable_voltage);
  const std::optional<DriveState> state = drive.state();
  if (!state || !released || powered(*state)) {
    std::fprintf(stderr, "node %d: NOT CONFIRMED that the motor is off (%s): cut its power\n", node.node(),
                 state ? name_of(*state) : node.failure().c_str());
    return ExitCode::fault;
  }
  std::printf("%s\n", name_of(*state));
  return ExitCode::ok;
}

bool confirmed(const DriveOptions& options) {
  if (options.hand_on_the_stop) return true;
  std::fprintf(stderr,
               "this verb moves the motor: give --hand-on-the-stop once you see the whole rig and have your "
               "hand on its emergency stop\n");
  return false;
}

ExitCode home(const DriveOptions& options) {
  if (!stands_still(options.home.method) && !confirmed(options)) return ExitCode::usage;
  guard_process();
  const StopSignals signals(Suspension::stops);
  DriveDialogue drive(options.node);
  if (const ExitCode code = drive.open(); code != ExitCode::ok) return code;
  return home_drive(drive, options.home, signals.requested());
}

/// Takes the one given value, and checks it against its limit.
bool take_value(DriveOptions& options) {
  struct Choice {
    const std::optional<double>& value;
    CommandKind kind;
    double limit;
  };
  const std::array choices{Choice{options.velocity, CommandKind::velocity, limit_velocity_counts_per_s},
                           Choice{options.position, CommandKind::position, limit_position_counts},
                           Choice{options.torque, CommandKind::torque, limit_torque_per_mille}};
  const auto is_given = [](const Choice& choice) { return choice.value.has_value(); };
  if (std::ranges::count_if(choices, is_given) != 1) {
    std::fprintf(stderr, "exactly one of --velocity, --position and --torque is required\n");
    return false;
  }
  const Choice& choice = *std::ranges::find_if(choices, is_given);
  options.move.kind = choice.kind;
  options.move.value = *choice.value;
  const double limit = options.limit.value_or(choice.limit);
  if (std::abs(options.move.value) > limit) {
    std::fprintf(stderr, "%g is beyond the limit of %g: raise it with --limit\n", options.move.value, limit);
    return false;
  }
  const double speed = std::abs(options.move.value) * MoveRamp(options.move.duration).peak_rate();
  if (options.position && speed > options.speed_limit) {
    std::fprintf(stderr,
                 "%g counts in %g s need %.0f counts/s, beyond the limit of %g counts/s: raise --duration or "
                 "--speed-limit\n",
                 options.move.value, options.move.duration, speed, options.speed_limit);
    return false;
  }
  return true;
}

ExitCode move(DriveOptions& options) {
  if (!take_value(options) || !confirmed(options)) return ExitCode::usage;
  guard_process();
  const StopSignals signals(Suspension::stops);
  DriveDialogue drive(options.node);
  if (const ExitCode code = drive.open(); code != ExitCode::ok) return code;
  return move_drive(drive, options.move, signals.requested());
}

void add_home(CLI::App& verb, const std::shared_ptr<DriveOptions>& options, ExitCode& code) {
  CLI::App* homing = verb.add_subcommand("home", "Home the drive, then turn it off.");
  HomeOptions& home_options = options->home;
  homing
      ->add_option("--method", home_options.method,
                   "use this homing method (6098h). 37, in older drives 35: here, without moving; negative: "
                   "the maker's")
      ->check(CLI::Range(-128, 127))
      ->capture_default_str();
  homing->add_option("--switch-speed", home_options.switch_speed,
                     "set the speed towards the switch, counts/s (6099h:01)");
  homing->add_option("--zero-speed", home_options.zero_speed,
                     "set the speed towards the index, counts/s (6099h:02)");
  homing->add_option("--acceleration", home_options.acceleration, "set the acceleration, counts/s^2 (609Ah)");
  homing->add_option("--offset", home_options.offset, "set the position at home, counts (607Ch)");
  homing->add_option("--within", home_options.within, "end the homing after this time, s")
      ->check(number_above(0, 600))
      ->capture_default_str();
  homing->add_flag("--hand-on-the-stop", options->hand_on_the_stop,
                   "confirm that you see the whole rig and have your hand on its emergency stop; required "
                   "where the method moves");
  homing->callback([options, &code] { code = home(*options); });
}

void add_move(CLI::App& verb, const std::shared_ptr<DriveOptions>& options, ExitCode& code) {
  CLI::App* moving = verb.add_subcommand(
      "move", "Move the motor with a ramp up in the first quarter and down in the last, then turn it off.");
  constexpr double largest_counts = 1e9, largest_per_mille = 1000;
  const CLI::Validator counts = number_in(-largest_counts, largest_counts);
  moving
      ->add_option("--velocity", options->velocity,
                   "move at this velocity, counts/s (CSV, 60FFh); at most 2000 without --limit")
      ->check(counts);
  moving
      ->add_option("--position", options->position,
                   "move by this distance from here, counts (CSP, 607Ah); at most 2000 without --limit")
      ->check(counts);
  moving
      ->add_option(
          "--torque", options->torque,
          "apply this torque, per mille of the rated torque 6076h (CST, 6071h); at most 50 without --limit")
      ->check(number_in(-largest_per_mille, largest_per_mille));
  moving->add_option("--duration", options->move.duration, "move for this time, s")
      ->required()
      ->check(number_in(0.1, 60));
  moving->add_option("--limit", options->limit, "allow values up to this one, in the unit of the value")
      ->check(number_above(0, largest_counts));
  moving
      ->add_option("--speed-limit", options->speed_limit, "allow --position speeds up to this one, counts/s")
      ->check(number_above(0, largest_counts))
      ->capture_default_str();
  moving->add_flag("--hand-on-the-stop", options->hand_on_the_stop,
                   "confirm that you see the whole rig and have your hand on its emergency stop; required");
  moving->callback([options, &code] { code = move(*options); });
}

}  // namespace

void add_drive(CLI::App& app, ExitCode& code) {
  CLI::App* verb =
      app.add_subcommand("drive", "Bring up one CiA 402 drive: status, reset, homing, short moves.");
  const auto options = std::make_shared<DriveOptions>();
  add_node_options(*verb, options->node);
  verb->require_subcommand(1);
  verb->fallthrough();
  verb->add_subcommand("status", "Print state, mode, error, position, velocity, torque.")
      ->callback([options, &code] { code = print_status(*options); });
  verb->add_subcommand("reset", "Reset a fault, and print the remaining error.")->callback([options, &code] {
    code = reset(*options);
  });
  verb->add_subcommand("quick-stop", "Brake as 605Ah prescribes, then turn the drive off.")
      ->callback([options, &code] { code = quick_stop(*options); });
  add_home(*verb, options, code);
  add_move(*verb, options, code);
}

}  // namespace godobject
