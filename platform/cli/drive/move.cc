// Homing and moving of one drive.
#include "platform/cli/drive/drive.h"

#include <unistd.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "hal/drive/cia402_text.h"
#include "platform/rt/background_file.h"
#include "platform/rt/cyclic.h"

namespace godobject {

using cia402::Homing;

using cia402::CommandKind;

namespace {

bool configure(NodeDialogue& node, const HomeOptions& options) {
  const auto set = [&node](const TypedObject& object, const auto& value) {
    return !value || node.write(object, *value);
  };
  return node.write(drive_object::homing_method, options.method) &&
         set(drive_object::homing_switch_speed, options.switch_speed) &&
         set(drive_object::homing_zero_speed, options.zero_speed) &&
         set(drive_object::homing_acceleration, options.acceleration) &&
         set(drive_object::home_offset, options.offset);
}

ExitCode failed(NodeDialogue& node, const char* what, const std::string& hint) {
  std::fprintf(stderr, "node %d: homing %s: %s\n", node.node(), what, hint.c_str());
  return ExitCode::fault;
}

ExitCode tell_outcome(NodeDialogue& node, const HomeOptions& options, Homing::Result result) {
  if (result == Homing::Result::timed_out)
    return failed(node, "did not end in time", "raise --within, and check the method's switch");
  if (result == Homing::Result::failed) {
    const std::optional<std::int64_t> error = node.read(drive_object::error_code);
    return failed(node, "failed",
                  (error ? error_code_text(*error) : node.failure()) + "; check that the drive has method " +
                      std::to_string(options.method) + ", and check switch and index");
  }
  const std::optional<std::int64_t> position = node.read(drive_object::position);
  if (!position) return node.report();
  std::printf("home was found, at %lld counts\n", static_cast<long long>(*position));
  return ExitCode::ok;
}

ExitCode run_homing(DriveDialogue& drive, const HomeOptions& options, const std::atomic<bool>& stop) {
  constexpr Nanoseconds step_period_ns = 10'000'000;
  NodeDialogue& node = drive.node();
  Homing homing(static_cast<Nanoseconds>(1e9 * options.within));
  for (;;) {
    if (stop) return failed(node, "interrupted", "home was not found");
    const std::optional<std::uint16_t> word = drive.statusword();
    if (!word) return node.report();
    const std::uint16_t controlword = homing.step(*word, MonotonicClock().now());
    if (homing.finished()) return tell_outcome(node, options, homing.result());
    if (!drive.command(controlword)) return node.report();
    node.wait(step_period_ns);
  }
}

constexpr Nanoseconds command_period_ns = 10'000'000, line_period_ns = 200'000'000,
                      settling_ns = 100'000'000;  // wait before the last line

const TypedObject& target_of(CommandKind kind) noexcept {
  switch (kind) {
    case CommandKind::velocity: return drive_object::target_velocity;
    case CommandKind::position: return drive_object::target_position;
    case CommandKind::torque: break;
  }
  return drive_object::target_torque;
}

class Move {
 public:
  /// out: file or terminal, buffered, so that a blocked terminal does not keep the motor moving.
  Move(DriveDialogue& drive, const MoveOptions& options, BackgroundFile& out)
      : drive_(drive), node_(drive.node()), options_(options), out_(out), ramp_(options.duration) {}

  ExitCode set_at_rest() {
    const std::optional<std::int64_t> position = node_.read(drive_object::position);
    if (!position) return node_.report();
    start_ = *position;
    return node_.write(target_of(options_.kind), target(0)) ? ExitCode::ok : node_.report();
  }

  ExitCode run(const std::atomic<bool>& stop) {
    print("%6s %12s %12s %12s %12s\n", "s", "target", "counts", "counts/s", "per mille");
    const MonotonicClock clock;
    const Nanoseconds t_begin_ns = clock.now();
    Nanoseconds t_line_ns = t_begin_ns;
    for (double t = 0; t <= options_.duration;) {
      if (stop) return interrupted(t);
      if (const ExitCode code = command(t); code != ExitCode::ok) return code;
      if (clock.now() >= t_line_ns) {
        if (const ExitCode code = print_line(t); code != ExitCode::ok) return code;
        t_line_ns += line_period_ns;
      }
      node_.wait(command_period_ns);
      t = 1e-9 * static_cast<double>(clock.now() - t_begin_ns);
    }
    const ExitCode code = command(options_.duration);
    if (code != ExitCode::ok) return code;
    node_.wait(settling_ns);
    return print_line(options_.duration);
  }

  /// Returns the time of an interruption, s.
  std::optional<double> interrupted_s() const { return interrupted_s_; }

 private:
  std::int64_t target(double t) const noexcept {
    const bool position = options_.kind == CommandKind::position;
    const auto change = std::llround(options_.value * (position ? ramp_.way(t) : ramp_.rate(t)));
    // counts are modulo 2^32
    return position ? static_cast<std::int32_t>(static_cast<std::uint32_t>(start_ + change)) : change;
  }

  ExitCode command(double t) {
    if (!node_.write(target_of(options_.kind), target(t))) return node_.report();
    const std::optional<cia402::DriveState> state = drive_.state();
    if (!state) return node_.report();
    if (*state == cia402::DriveState::operation_enabled) return ExitCode::ok;
    const std::optional<std::int64_t> error = node_.read(drive_object::error_code);
    std::fprintf(stderr, "node %d: left Operation Enabled for %s after %.2f s, %s\n", node_.node(),
                 name_of(*state), t, error ? error_code_text(*error).c_str() : node_.failure().c_str());
    return ExitCode::fault;
  }

  template <class... Values>
  void print(const char* format, Values... values) {
    std::array<char, 120> line{};
    std::snprintf(line.data(), line.size(), format, values...);
    static_cast<void>(out_.write(line.data()));
  }

  ExitCode print_line(double t) {
    const std::optional<std::int64_t> position = node_.read(drive_object::position);
    if (!position) return node_.report();
    const std::optional<std::int64_t> velocity = node_.read(drive_object::velocity);
    if (!velocity) return node_.report();
    const std::optional<std::int64_t> torque = node_.read(drive_object::torque);
    if (!torque) return node_.report();
    print("%6.2f %12lld %12lld %12lld %12lld\n", t, static_cast<long long>(target(t)),
          static_cast<long long>(*position), static_cast<long long>(*velocity),
          static_cast<long long>(*torque));
    return ExitCode::ok;
  }

  ExitCode interrupted(double t) {
    interrupted_s_ = t;
    return ExitCode::fault;
  }

  DriveDialogue& drive_;
  NodeDialogue& node_;
  const MoveOptions& options_;
  BackgroundFile& out_;
  MoveRamp ramp_;
  std::int64_t start_ = 0;  // counts
  std::optional<double> interrupted_s_;
};

}  // namespace

ExitCode home_drive(DriveDialogue& drive, const HomeOptions& options, const std::atomic<bool>& stop) {
  PoweredDrive power(drive);
  ExitCode code = power.prepare(cia402::OperationMode::homing);
  if (code == ExitCode::ok && !configure(drive.node(), options)) code = drive.node().report();
  if (code == ExitCode::ok) code = power.enable();
  if (code == ExitCode::ok) code = run_homing(drive, options, stop);
  const ExitCode off = power.off();
  if (off == ExitCode::ok) std::printf("off\n");
  return code == ExitCode::ok ? off : code;
}

ExitCode move_drive(DriveDialogue& drive, const MoveOptions& options, const std::atomic<bool>& stop) {
  constexpr std::size_t out_bytes = 1 << 16;
  constexpr std::chrono::seconds out_patience{2};
  BackgroundFile out(STDOUT_FILENO, out_bytes);
  PoweredDrive power(drive);
  Move move(drive, options, out);
  ExitCode code = power.prepare(cia402::mode_of(options.kind));
  if (code == ExitCode::ok) code = move.set_at_rest();
  if (code == ExitCode::ok) code = power.enable();
  if (code == ExitCode::ok) code = move.run(stop);
  const ExitCode off = power.off();
  if (off == ExitCode::ok) static_cast<void>(out.write("off\n"));
  static_cast<void>(out.close(BackgroundFile::Clock::now() + out_patience));
  if (const std::optional<double> t = move.interrupted_s())  // printed after the motor is off
    std::fprintf(stderr, "node %d: interrupted after %.2f s\n", drive.node().node(), *t);
  return code == ExitCode::ok ? off : code;
}

}  // namespace godobject
