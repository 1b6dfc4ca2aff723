// A rig on a scripted device, the events of rig, drive and link, and the promises that hold in every cycle.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "hal/rig/rig.h"
#include "tests/support/scripted_device.h"

namespace godobject::test {

inline constexpr double cycle_s = 1e-3, torque_max_Nm = 0.1, torque_rate_Nm_per_s = 25;
// 0.1 N m at 25 N m/s, and 3 cycles
inline constexpr int ramp_cycles = 4 + 3;
// stale_after 3 ms and lost_after 8 ms, and 2 cycles
inline constexpr int lost_cycles = 3 + 8 + 2;
inline constexpr int longest_timeout_cycles = 70;
// 0.1 s at rest, and a boot or a timeout before
inline constexpr int rest_cycles = 100, longest_wait_cycles = longest_timeout_cycles + rest_cycles;
inline constexpr int counts_of_a_move = 20;
inline constexpr std::uint32_t counts_lost_by_restart = 5000;

inline RigParams params_of_rig() {
  RigParams rig;
  rig.buses = {{.name = "can0"}};
  rig.tree.joints = {{.name = "yaw"}};
  rig.tree.handles = {{.body = "tool", .joint = "yaw", .X_LH = {Vec3(0.1, 0, 0), Quat::Identity()}}};
  rig.encoders = {{.joint = "yaw", .node_id = encoder_id, .calibration = {.counts_per_unit = 1000}}};
  rig.drives = {{.joint = "yaw",
                 .node_id = drive_id,
                 .torque_rated_Nm = torque_max_Nm,
                 .torque_max_Nm = torque_max_Nm,
                 .torque_rate_Nm_per_s = torque_rate_Nm_per_s,
                 .calibration = {.counts_per_unit = 1000}}};
  rig.buttons = {{.use = ButtonUse::stop, .node_id = input_id}};
  rig.lost_after_s = 8e-3;
  rig.boot_timeout_s = 60e-3;
  rig.heartbeat_timeout_s = 30e-3;
  rig.heartbeat_period_s = 10e-3;
  return rig;
}

/// Returns the rig with an incremental encoder: its home pose is at 0.5 rad.
inline RigParams params_of_incremental_rig() {
  RigParams rig = params_of_rig();
  rig.encoders[0].calibration.incremental = true;
  rig.encoders[0].calibration.home = 0.5;
  rig.buttons.push_back({.use = ButtonUse::home, .node_id = input_id, .bit = 1});
  return rig;
}

/// Returns the rig with a drive of another protocol, on a bus of its own.
inline RigParams params_of_rig_with(DriveProtocol protocol) {
  RigParams rig = params_of_rig();
  if (protocol == DriveProtocol::cia402) return rig;
  rig.buses.push_back({.name = "can1", .data_bit_rate = protocol == DriveProtocol::moteus ? 5e6 : 0});
  rig.drives[0].protocol = protocol;
  rig.drives[0].bus = 1;
  return rig;
}

enum class RigTrial : std::uint8_t {
  start,
  arm,
  disarm,
  clear,
  quick_stop,
  switch_off,
  press_stop,
  release_stop,
  deadlines_missed,
  force_oscillates,
  energy_gained,
  not_finite,
  bus_off,
  bus_on,
  queue_full,
  queue_free,
  drive_power_off,
  drive_power_on,
  drive_error,
  drive_disabled,
  encoder_unplugged,
  encoder_plugged,
  encoder_restarts,
  second_host,
  cycle,
  wait,
  // with an incremental encoder:
  press_home,
  release_home,
  move
};
inline constexpr int num_rig_trials = 26, num_incremental_rig_trials = 29;
inline constexpr std::array rig_trial_names{"start",
                                            "arm",
                                            "disarm",
                                            "clear",
                                            "quick_stop",
                                            "switch_off",
                                            "press_stop",
                                            "release_stop",
                                            "deadlines_missed",
                                            "force_oscillates",
                                            "energy_gained",
                                            "not_finite",
                                            "bus_off",
                                            "bus_on",
                                            "queue_full",
                                            "queue_free",
                                            "drive_power_off",
                                            "drive_power_on",
                                            "drive_error",
                                            "drive_disabled",
                                            "encoder_unplugged",
                                            "encoder_plugged",
                                            "encoder_restarts",
                                            "second_host",
                                            "cycle",
                                            "wait",
                                            "press_home",
                                            "release_home",
                                            "move"};
static_assert(rig_trial_names.size() == num_incremental_rig_trials);

/// A rig on the device, and the promises that hold in every cycle.
class SupervisedRig {
 public:
  explicit SupervisedRig(RigParams of_rig = params_of_rig())
      : device(of_rig.drives[0].protocol), params(std::move(of_rig)) {}
  explicit SupervisedRig(DriveProtocol protocol) : SupervisedRig(params_of_rig_with(protocol)) {}

  void apply(RigTrial event) {
    bool finite = true;
    int cycles = 1;
    requested_ = requested_ || event == RigTrial::arm;
    switch (event) {
      case RigTrial::start: rig.start(now_); break;
      case RigTrial::arm: static_cast<void>(rig.arm()); break;
      case RigTrial::disarm: rig.disarm(); break;
      case RigTrial::clear: rig.clear_faults(now_); break;
      case RigTrial::quick_stop: rig.quick_stop(); break;
      case RigTrial::switch_off: rig.stop(); break;
      case RigTrial::press_stop:
      case RigTrial::release_stop:
        device.stop_pressed = event == RigTrial::press_stop;
        device.send_inputs(now_);
        break;
      case RigTrial::deadlines_missed: rig.deadlines_missed(); break;
      case RigTrial::force_oscillates: rig.force_oscillates(0); break;
      case RigTrial::energy_gained: rig.energy_gained(); break;
      case RigTrial::not_finite: finite = false; break;
      case RigTrial::bus_off:
      case RigTrial::bus_on: device.is_off = event == RigTrial::bus_off; break;
      case RigTrial::queue_full:
      case RigTrial::queue_free: device.is_full = event == RigTrial::queue_full; break;
      case RigTrial::drive_power_off:
      case RigTrial::drive_power_on: device.power_drive(event == RigTrial::drive_power_on, now_); break;
      case RigTrial::drive_error: device.fail_drive(now_); break;
      case RigTrial::drive_disabled: device.disable_drive(); break;
      case RigTrial::encoder_unplugged:
      case RigTrial::encoder_plugged: device.encoder_plugged = event == RigTrial::encoder_plugged; break;
      case RigTrial::encoder_restarts:
        if (rig.needs_homing()) device.encoder_counts += counts_lost_by_restart;
        is_homed_ = false;
        device.encoder_nmt = NmtState::pre_operational;
        if (device.encoder_plugged) device.send(canopen::make_heartbeat(encoder_id, NmtState::boot_up), now_);
        break;
      case RigTrial::second_host: device.send(canopen::make_sync(), now_); break;
      case RigTrial::cycle: break;
      case RigTrial::wait: cycles = rig.needs_homing() ? longest_wait_cycles : longest_timeout_cycles; break;
      case RigTrial::press_home:
      case RigTrial::release_home:
        device.home_pressed = event == RigTrial::press_home;
        device.send_inputs(now_);
        break;
      case RigTrial::move:
        device.move(counts_of_a_move);
        cycles_at_rest_ = 0;
        break;
    }
    for (int i = 0; i < cycles; ++i) cycle(finite);
  }

  Nanoseconds now() const { return now_; }

  auto key() const {
    const bool link_is_open = !device.is_off && !device.is_full;
    const int drive = device.drive == DriveState::operation_enabled ? 1
                      : device.drive == DriveState::fault           ? 2
                                                                    : 0;
    return std::tuple(rig.state(), rig.torque_output(), rig.drive_feedback(0, now_).state, drive,
                      device.drive_powered, device.drive_nmt == NmtState::operational, link_is_open,
                      device.is_off, device.encoder_plugged, device.encoder_nmt == NmtState::operational,
                      device.stop_pressed, rig.commanded_torque_Nm(0) != 0, device.home_pressed, is_homed_,
                      has_zero(), cycles_at_rest_ >= rest_cycles);
  }

  ScriptedDevice device;
  std::vector<CanBus*> buses = device.buses();
  const RigParams params;
  Rig rig{params, cycle_s, buses};
  std::string broken;  // the first broken promise

 private:
  void cycle(bool finite) {
    const double before_Nm = rig.commanded_torque_Nm(0);
    Wrench F{};
    F.f.y() = finite ? 10 : std::numeric_limits<double>::quiet_NaN();
    rig.sync(now_);
    device.answer(now_);
    rig.receive(now_ + ms / 2);
    cycles_at_rest_ = rig.needs_homing() && rig.state() == RigState::homing ? cycles_at_rest_ + 1 : 0;
    const bool had_zero = has_zero();
    const DeviceSample sample = rig.read(now_ + ms / 2);
    if (!had_zero && has_zero()) note_homing();
    static_cast<void>(rig.command(std::span(&F, 1), now_ + ms / 2));
    device.end_cycle();
    now_ += ms;
    check(sample, before_Nm);
  }

  void check(const DeviceSample& sample, double before_Nm) {
    const bool is_armed = rig.state() == RigState::armed;
    const double torque_Nm = rig.commanded_torque_Nm(0);
    const double largest_change_Nm = torque_rate_Nm_per_s * cycle_s * (1 + 1e-9);
    const bool has_torque = device.torque_per_mille != 0;
    cycles_not_armed_ = is_armed ? 0 : cycles_not_armed_ + 1;
    cycles_at_once_ = rig.torque_output() == TorqueOutput::at_once ? cycles_at_once_ + 1 : 0;
    cycles_without_pose_ = sample.valid && sample.fresh ? 0 : cycles_without_pose_ + 1;
    cycles_sent_ = device.cycles_without_command <= 1 ? cycles_sent_ + 1 : 0;
    if (is_armed && !requested_) fail("armed without a request");
    if (!is_armed) requested_ = false;
    if (std::abs(torque_Nm) > torque_max_Nm) fail("torque above its limit");
    if (std::abs(device.torque_per_mille) > 1000) fail("torque of the motor above its limit");
    if (torque_Nm != 0 && std::abs(torque_Nm - before_Nm) > largest_change_Nm) fail("torque above its rate");
    if (cycles_not_armed_ > torque_delay_ && std::abs(torque_Nm) > std::abs(before_Nm))
      fail("torque rises unarmed");
    if (is_armed && cycles_without_pose_ > lost_cycles) fail("armed without a live hand");
    if (is_armed && rig.faults() != RigFault::none) fail("armed with a fault");
    check_zero(sample, is_armed, has_torque);
    const bool is_reached = cycles_sent_ > ramp_cycles;
    if (has_torque && is_reached && cycles_not_armed_ > ramp_cycles) fail("torque after its ramp");
    if (has_torque && cycles_sent_ > 2 && cycles_at_once_ > 1) fail("torque after an emergency stop");
    if (has_torque && cycles_not_armed_ > watchdog_cycles + ramp_cycles) fail("torque after the watchdog");
  }
  bool has_zero() const { return rig.num_encoders() == 0 || rig.encoder(0).has_zero(); }
  void note_homing() {
    if (!device.home_pressed) fail("homed without a press");
    if (cycles_at_rest_ < rest_cycles) fail("homed while the joint moved");
    is_homed_ = true;
    counts_at_home_ = device.encoder_counts;
  }
  void check_zero(const DeviceSample& sample, bool is_armed, bool has_torque) {
    if (!rig.needs_homing() || params.encoders.empty()) return;
    const double count_rad = 1 / params.encoders[0].calibration.counts_per_unit;
    const double q = params.encoders[0].calibration.home +
                     count_rad * static_cast<std::int32_t>(device.encoder_counts - counts_at_home_);
    if (is_armed && !has_zero()) fail("armed without a zero");
    if (sample.valid && sample.fresh && !is_homed_) fail("a pose with the zero of before the restart");
    if (sample.valid && sample.fresh && std::abs(sample.q(0) - q) > count_rad) fail("a wrong pose");
    if (rig.state() != RigState::homing) return;
    if (sample.valid) fail("a pose while homing");
    if (has_torque || device.drive == DriveState::operation_enabled) ++cycles_enabled_;
    else cycles_enabled_ = 0;
    if (cycles_enabled_ > 2 && cycles_sent_ > 2) fail("drive enabled while homing");
  }
  void fail(const char* promise) {
    if (broken.empty()) broken = promise;
  }

  Nanoseconds now_ = 0;
  bool requested_ = false;  // arm() was called, and armed not left since
  bool is_homed_ = false;   // the home pose was confirmed, and the encoder has not restarted since
  std::uint32_t counts_at_home_ = 0;
  int cycles_enabled_ = 0, cycles_at_rest_ = 0;  // while homing
  // cycles from a torque to the request that carries it
  const int torque_delay_ = params.drives[0].protocol == DriveProtocol::moteus ? 1 : 0;
  int cycles_not_armed_ = 0, cycles_at_once_ = 0, cycles_without_pose_ = 0, cycles_sent_ = 0;
};

inline void cycles(SupervisedRig& world, int count) {
  for (int i = 0; i < count; ++i) world.apply(RigTrial::cycle);
}

inline void boot_and_arm(SupervisedRig& world) {
  for (const RigTrial event : {RigTrial::start, RigTrial::wait, RigTrial::arm}) world.apply(event);
  ASSERT_EQ(world.rig.state(), RigState::armed) << world.rig.fault_text();
}

}  // namespace godobject::test
