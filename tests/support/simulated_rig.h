// A rig on simulated wires, driven cycle by cycle. Default: a six-joint arm with an encoder on every joint
// (bus 0) and a drive on each of the first three (bus 1).
#pragma once

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "hal/rig/rig.h"
#include "sim/bus/can_bus.h"
#include "sim/node/drive.h"
#include "sim/node/encoder.h"
#include "sim/rig/plant.h"
#include "tests/support/phantom_arm.h"

namespace godobject::test {

inline constexpr std::size_t num_arm_drives = 3;
inline constexpr double arm_counts_per_rad = 16384 / (2 * 3.14159265358979323846);

/// Returns a rig of one slider along x, with a handle and a drive. Torques are those of DriveParams.
inline RigParams slider_rig_params(double joint_per_motor, double counts_per_unit) {
  RigParams rig;
  rig.buses = {{.name = "can0"}};
  rig.tree.joints = {{.name = "slide", .kind = DeviceJointKind::slider, .axis_J = Vec3::UnitX()}};
  rig.tree.handles = {{.body = "tool", .joint = "slide"}};
  DriveParams drive;
  drive.joint = "slide";
  drive.node_id = 1;
  drive.joint_per_motor_rad = joint_per_motor;
  drive.calibration.counts_per_unit = counts_per_unit;
  rig.drives = {drive};
  return rig;
}

inline RigParams arm_rig_params() {
  RigParams rig;
  rig.buses = {{.name = "can0"}, {.name = "can1"}};
  rig.tree = phantom_arm();
  for (std::size_t i = 0; i < rig.tree.joints.size(); ++i) {
    EncoderParams encoder;
    encoder.joint = rig.tree.joints[i].name;
    encoder.node_id = static_cast<std::uint8_t>(i + 1);
    encoder.calibration = {.counts_per_unit = arm_counts_per_rad,
                           .sign = i % 2 == 0 ? 1 : -1,
                           .offset_counts = static_cast<std::int64_t>(1000 * i),
                           .modulus_counts = 16384};
    rig.encoders.push_back(encoder);
  }
  for (std::size_t i = 0; i < num_arm_drives; ++i) {
    DriveParams drive;
    drive.joint = rig.tree.joints[i].name;
    drive.bus = 1;
    drive.node_id = static_cast<std::uint8_t>(i + 1);
    drive.torque_rated_Nm = 0.2;
    drive.torque_max_Nm = 0.15;
    drive.torque_rate_Nm_per_s = 20;
    drive.joint_per_motor_rad = 0.1;
    drive.sign = i == 1 ? -1 : 1;
    drive.calibration.counts_per_unit = 65536 / (2 * 3.14159265358979323846) / drive.joint_per_motor_rad;
    drive.calibration.sign = drive.sign;
    rig.drives.push_back(drive);
  }
  return rig;
}

class SimulatedRig {
 public:
  static constexpr Nanoseconds cycle_ns = 1'000'000;
  static constexpr double cycle_s = 1e-9 * cycle_ns;
  static constexpr Nanoseconds deadline_ns = 700'000;  // after SYNC: the answers should have arrived
  static constexpr Nanoseconds heartbeat_ns = 100'000'000;
  static constexpr Nanoseconds watchdog_ns = 20'000'000;  // as in the profiles

  SimulatedRig(const SimulatedRig&) = delete;  // references to this are stored
  SimulatedRig& operator=(const SimulatedRig&) = delete;
  explicit SimulatedRig(const RigParams& rig_params = arm_rig_params(), bool haptic = false,
                        const PlantConfig& plant_config = {}, SimDefaults defaults = SimDefaults::rig)
      : params(rig_params), plant(plant_config, rig_params.tree.joints.size(), haptic, zero(), 0) {
    for (std::size_t i = 0; i < params.buses.size(); ++i) {
      wires.emplace_back(SimWireParams{.rates = {.nominal = params.buses[i].bit_rate}, .seed = i + 1});
      hosts.push_back(&open_port(wires.back()));
    }
    nodes.resize(params.buses.size());
    for (const EncoderParams& e : params.encoders) {
      encoder_ports.push_back(&open_port(wires[e.bus]));
      encoders.push_back(std::make_unique<SimEncoder>(*encoder_ports.back(), e.node_id, e.calibration,
                                                      heartbeat_ns, defaults));
      nodes[e.bus].push_back(encoders.back().get());
    }
    for (const DriveParams& d : params.drives) {
      drive_ports.push_back(&open_port(wires[d.bus]));
      drives.push_back(
          std::make_unique<SimDrive>(*drive_ports.back(), SimDriveParams{.drive = d,
                                                                         .rpdo_timeout_ns = watchdog_ns,
                                                                         .heartbeat_period_ns = heartbeat_ns,
                                                                         .defaults = defaults}));
      nodes[d.bus].push_back(drives.back().get());
    }
    rig = std::make_unique<Rig>(params, cycle_s, hosts);
    // Nodes are switched on now; their heartbeats then fall 400 us after a SYNC, separate from the answers.
    advance_to(600'000);
    cycle_start_ns = now;
  }

  /// Runs one cycle: SYNC, answers, read, command. Joints follow q_ref; with haptics they are pulled to it.
  void cycle(std::span<const Wrench> F_hand_W = {}) {
    begin_cycle();
    end_cycle(F_hand_W);
  }
  /// Runs the cycle up to the sample.
  void begin_cycle() {
    rig->sync(now);
    advance_to(now + deadline_ns);
    rig->receive(now);
    complete = rig->complete();
    sample = rig->read(now);
  }
  /// Commands the wrenches and runs the rest of the cycle.
  void end_cycle(std::span<const Wrench> F_hand_W) {
    report = rig->command(F_hand_W, now);
    advance_to(cycle_start_ns += cycle_ns);
  }
  void cycle(const Wrench& F_hand_W) { cycle({&F_hand_W, 1}); }
  void cycles(int count, std::span<const Wrench> F_hand_W = {}) {
    for (int i = 0; i < count; ++i) cycle(F_hand_W);
  }
  void cycles(int count, const Wrench& F_hand_W) { cycles(count, {&F_hand_W, 1}); }
  /// Advances time on the buses without the rig.
  void idle(Nanoseconds duration) { advance_to(cycle_start_ns = now + duration); }
  /// Runs cycles until ready; returns false after 3 s.
  bool boot() {
    rig->start(now);
    for (int i = 0; i < 3000 && !rig->ready(); ++i) cycle();
    return rig->ready();
  }
  /// Returns the joint torque of a drive, after the transmission.
  double applied_joint_torque(std::size_t drive) const {
    const DriveParams& d = params.drives[drive];
    return d.sign * drives[drive]->applied_torque_Nm() / d.joint_per_motor_rad;
  }

  JointVector zero() const { return JointVector::Zero(static_cast<Eigen::Index>(params.tree.joints.size())); }
  Eigen::Index joint_named(const std::string& name) const {
    return std::ranges::find(params.tree.joints, name, &DeviceJoint::name) - params.tree.joints.begin();
  }

  RigParams params;
  SimPlant plant;
  std::deque<SimCanWire> wires;
  std::deque<SimCanPort> ports;
  std::vector<CanBus*> hosts;  // the host's port on each bus
  std::vector<SimCanPort*> encoder_ports, drive_ports;
  std::vector<std::unique_ptr<SimEncoder>> encoders;
  std::vector<std::unique_ptr<SimDrive>> drives;
  std::vector<std::vector<SimNode*>> nodes;  // by bus
  std::unique_ptr<Rig> rig;

  std::function<JointVector(double t)> q_ref = [this](double) { return zero(); };
  std::function<JointVector(double t)> q_ref_dot = [this](double) { return zero(); };
  Nanoseconds now = 0, cycle_start_ns = 0;
  DeviceSample sample;
  CommandReport report;
  bool complete = false;

 private:
  static constexpr Nanoseconds plant_step_ns = 50'000;

  SimCanPort& open_port(SimCanWire& wire) {
    SimCanPort& port = ports.emplace_back(wire);
    static_cast<void>(port.open());
    port.set_pdo_buffers();
    return port;
  }

  void advance_to(Nanoseconds t_ns) {
    while (now < t_ns) {
      now += plant_step_ns;
      for (std::size_t i = 0; i < drives.size(); ++i) {
        const Eigen::Index joint = joint_named(params.drives[i].joint);
        plant.set_motor_torque(static_cast<std::size_t>(joint), applied_joint_torque(i));
      }
      const double t = 1e-9 * static_cast<double>(now);
      plant.advance(now, q_ref(t), q_ref_dot(t));
      for (std::size_t i = 0; i < encoders.size(); ++i) {
        encoders[i]->set_position(plant.q()(joint_named(params.encoders[i].joint)));
      }
      for (std::size_t i = 0; i < drives.size(); ++i) {
        const Eigen::Index joint = joint_named(params.drives[i].joint);
        drives[i]->set_joint(plant.q()(joint), plant.q_dot()(joint));
      }
      for (std::size_t bus = 0; bus < wires.size(); ++bus) advance(wires[bus], nodes[bus], now);
    }
  }
};

}  // namespace godobject::test
