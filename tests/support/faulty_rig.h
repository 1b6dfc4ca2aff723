// A small haptic device on simulated buses, with its host and a hand that moves it, for fault injection. Its
// joints are turret and elbow, each with an encoder on can0 (nodes 1, 2) and a drive on can1 (nodes 1, 2).
// Its emergency stop is node 3 on can0.
#pragma once

#include <algorithm>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>

#include "hal/rig/rig.h"
#include "platform/scene/toml.h"
#include "platform/simulated/session.h"
#include "sim/rig/link.h"

namespace godobject::test {

inline constexpr const char* two_joints_toml = R"(
[scene]
name = "two-joints"
[[body]]
name = "tool"
mass = 0.1
inertia = [3e-5, 3e-5, 3e-5]
[body.coupling]
stiffness = 200.0
damping_ratio = 1.4
rotational_stiffness = 0.1
rotational_damping_ratio = 1.4
[body.feedback]
stiffness = 100.0
damping = 1.0
[[bus]]
name = "can0"
[[bus]]
name = "can1"
[device]
name = "arm"
kind = "impedance"
[[device.joint]]
name = "turret"
kind = "hinge"
axis = [0.0, 0.0, 1.0]
[[device.joint]]
name = "elbow"
kind = "hinge"
position = [0.1, 0.0, 0.0]
axis = [0.0, 1.0, 0.0]
[[device.handle]]
body = "tool"
joint = "elbow"
position = [0.1, 0.0, 0.0]
[[device.encoder]]
joint = "turret"
bus = "can0"
node_id = 1
counts_per_turn = 16384
offset_counts = 8192
modulus_counts = 16384
[[device.encoder]]
joint = "elbow"
bus = "can0"
node_id = 2
counts_per_turn = 16384
offset_counts = 8192
modulus_counts = 16384
[[device.drive]]
joint = "turret"
bus = "can1"
node_id = 1
profile = "generic-402"
torque_rated_Nm = 0.1
torque_max_Nm = 0.1
torque_rate_Nm_per_s = 20.0
joint_per_motor_rad = 0.1
counts_per_turn = 40960
[[device.drive]]
joint = "elbow"
bus = "can1"
node_id = 2
profile = "generic-402"
torque_rated_Nm = 0.1
torque_max_Nm = 0.1
torque_rate_Nm_per_s = 20.0
joint_per_motor_rad = 0.1
counts_per_turn = 40960
[[device.button]]
use = "stop"
bus = "can0"
node_id = 3
[[motion.joint]]
coordinate = "turret"
amplitude = 0.3
frequency_hz = 0.7
[[motion.joint]]
coordinate = "elbow"
amplitude = 0.3
frequency_hz = 0.9
)";

/// Scene for temporarily slow machines: samples may be late, the drives' deadlines are unchanged.
inline std::string patient_toml() {
  std::string text = two_joints_toml;
  text.insert(text.find("[[body]]"), "step = 5e-3\n");
  text.insert(text.find("[[device.joint]]"), "[device.supervision]\nstale_after = 0.2\n");
  for (std::size_t at = 0; (at = text.find("modulus_counts", at)) != std::string::npos;) {
    text.insert(at, "max_speed = 10.0\n");
    at += 40;
  }
  return text;
}

inline SceneConfig two_joints() {
  LoadResult loaded = parse_scene(two_joints_toml, "two-joints");
  if (!loaded.scene) throw std::runtime_error(loaded.errors.front());
  return *loaded.scene;
}

/// Returns the scene with drives of this protocol instead.
inline SceneConfig two_joints(DriveProtocol protocol, DriveWatchdog watchdog) {
  SceneConfig scene = two_joints();
  RigParams& rig = *scene.device->rig;
  if (protocol == DriveProtocol::moteus) rig.buses[1].data_bit_rate = 5e6;
  for (DriveParams& drive : rig.drives) {
    drive.profile.clear();
    drive.protocol = protocol;
    drive.watchdog = watchdog;
    drive.calibration.counts_per_unit =
        counts_per_motor_turn / (2 * std::numbers::pi * drive.joint_per_motor_rad);
  }
  return scene;
}

inline RigProfiles profiles_of(const SceneConfig& scene) {
  RigProfilesResult loaded = load_profiles(*scene.device->rig, scene.step, "");
  if (!loaded.errors.empty()) throw std::runtime_error(loaded.errors.front());
  return std::move(loaded.profiles);
}

/// Cycles of the rig as in a session, with a constant displayed wrench. Link: a RigLink constructed like
/// SimLink, with rig(). The nodes are set up by the scene's profiles.
template <class Link>
class FaultyRigOn {
 public:
  static constexpr double period_s = 1e-3;
  static constexpr Nanoseconds period_ns = 1'000'000, poll_ns = 50'000, gather_ns = 750'000;

  explicit FaultyRigOn(const SceneConfig& config = two_joints())
      : scene(config),
        link(sim_rig_config(scene), period_s, hand_of(Motion(scene)), poll_ns, profiles_of(scene)),
        rig(*scene.device->rig, period_s, link.buses()) {}

  void cycle() {
    t_sync_ns = link.begin_cycle(motion_time);
    rig.sync(t_sync_ns);
    Nanoseconds now = t_sync_ns;
    while (!rig.complete() && now < t_sync_ns + gather_ns) {
      now = link.wait(t_sync_ns + gather_ns);
      rig.receive(now);
    }
    sample = rig.read(now);
    static_cast<void>(rig.command({&F_hand_W, 1}, now));
    motion_time += 1e-9 * static_cast<double>(period_ns);
  }
  void cycles(int count) {
    for (int i = 0; i < count; ++i) cycle();
  }
  /// Boots and arms, with torque on the motors; returns false after 2 s.
  bool boot() {
    if (rig.state() == RigState::off) rig.start(t_sync_ns);
    for (int i = 0; i < 2000 && rig.state() != RigState::ready; ++i) cycle();
    if (!rig.arm()) return false;
    cycles(50);
    return rig.state() == RigState::armed && motor_torque() > 0;
  }
  /// Injects a fault, e.g. "emcy bus=can1 node=2", from the next cycle on.
  void play(const std::string& words) {
    std::string error;
    const std::optional<FaultConfig> config = parse_fault(words, error);
    const FaultResult found = config ? resolve(*config, *scene.device->rig) : FaultResult{};
    if (!found.fault || !link.rig().faults().schedule(*found.fault))
      throw std::runtime_error(words + ": " + error + found.error);
  }
  /// Returns the cycles until a fault is raised; nullopt if none within `limit` cycles.
  std::optional<int> cycles_to_fault(int limit) {
    for (int i = 1; i <= limit; ++i) {
      cycle();
      if (rig.state() == RigState::fault) return i;
    }
    return std::nullopt;
  }
  /// Returns the cycles until no motor has torque; nullopt if not within `limit` cycles.
  std::optional<int> cycles_to_zero(int limit) {
    for (int i = 0; i <= limit; ++i) {
      if (motor_torque() == 0) return i;
      cycle();
    }
    return std::nullopt;
  }
  /// Returns the largest absolute torque at a motor shaft, N m.
  double motor_torque() {
    double largest = 0;
    for (std::size_t i = 0; i < rig.num_drives(); ++i)
      largest = std::max(largest, std::abs(link.rig().applied_torque_Nm(i)));
    return largest;
  }

  SceneConfig scene;
  Link link;
  Rig rig;
  DeviceSample sample;
  Wrench F_hand_W{.tau = Vec3::Zero(), .f = Vec3(0, 2, 2)};
  double motion_time = 0;  // s
  Nanoseconds t_sync_ns = 0;
};
using FaultyRig = FaultyRigOn<SimLink>;

}  // namespace godobject::test
