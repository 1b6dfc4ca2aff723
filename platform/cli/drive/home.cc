#include "platform/cli/drive/home.h"

#include <cstdio>

#include "platform/rt/clock.h"

namespace godobject {

using cia402::Homing;

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

}  // namespace godobject
