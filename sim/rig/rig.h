// The simulated rig a scene describes: wires, encoder and drive nodes on them, the mechanics under them and
// the hand that moves it. The other end of the buses is a Rig that knows nothing of this.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "hal/can/bus_load.h"
#include "hal/canopen/node_profile.h"
#include "hal/rig/link.h"
#include "sim/fault/injector.h"
#include "sim/rig/inverse_kinematics.h"
#include "platform/session/motion.h"
#include "sim/node/button.h"
#include "sim/node/encoder.h"
#include "sim/rig/plant.h"

namespace godobject {

/// What the simulated nodes send besides their answers to SYNC: a heartbeat well within the host's timeout.
BusLoadParams simulated_load(const RigParams& rig) noexcept;

/// What the hand feels of such a device is the torque of its drives.
constexpr bool shows_force(DeviceKind kind) noexcept {
  return kind == DeviceKind::impedance || kind == DeviceKind::relative;
}

class SimRig {
 public:
  /// Why the scene's rig, which must be valid, cannot follow the motion; empty when it can. Poses need
  /// inverse kinematics, which not every device has; columns of joints do for all of them.
  static std::string why_not(const SceneConfig& scene, const Motion& motion);

  /// scene.device->rig must be there and valid, why_not() empty. profiles: what the nodes have been set up by
  /// and have stored; without, it is for the host to do. Allocates; nothing later does.
  SimRig(const SceneConfig& scene, const Motion& motion, const RigProfiles& profiles = {});
  SimRig(const SimRig&) = delete;
  SimRig& operator=(const SimRig&) = delete;

  /// The host's port on each bus, open.
  std::span<CanBus* const> host_buses() const noexcept { return host_buses_; }
  void set_observer(const BusObserver& observer) noexcept;

  /// Runs the wires and the nodes up to t.
  void run_wires(Nanoseconds t) noexcept;
  /// When run_wires() has something to do again; none when nothing is under way.
  std::optional<Nanoseconds> next_event() const noexcept;
  /// Begins and ends the faults that are due, and moves the mechanics to t under the torque the drives apply now; the hand is where the motion is at
  /// motion_time (s).
  void run_plant(Nanoseconds t, double motion_time) noexcept;

  /// The scene's faults are scheduled in it.
  FaultInjector& faults() noexcept { return faults_; }
  const FaultInjector& faults() const noexcept { return faults_; }
  /// An open port for one more node on a bus. Allocates: set-up.
  SimCanPort& attach(std::size_t bus) { return add_port(bus); }
  SimCanPort& host_port(std::size_t bus) noexcept { return buses_[bus]->host; }
  /// At the motor's shaft, by the drive of this index.
  double applied_torque_Nm(std::size_t drive) const noexcept {
    return drives_[drive].motor->applied_torque_Nm();
  }

  /// Where the handle of this index really is, and how it moves: what the encoders measure.
  MotionSample handle(std::size_t index) const noexcept;
  /// Where its joints really are.
  JointTarget joints() const noexcept { return {.q = plant_->q(), .q_dot = plant_->q_dot()}; }
  /// True while every pose so far could be reached by the device.
  bool reachable() const noexcept { return reachable_; }
  /// Mean load of bus since the start, in percent.
  double load_percent(std::size_t bus, Nanoseconds now) const noexcept;

 private:
  struct Bus {
    explicit Bus(const SimWireParams& params) : wire(params), host(wire) {}
    SimCanWire wire;
    SimCanPort host;
    std::vector<std::unique_ptr<SimCanPort>> ports;
    std::vector<SimNode*> nodes;
    SimRig* rig = nullptr;
    std::size_t index = 0;
  };
  struct EncoderAt {
    std::unique_ptr<SimEncoder> node;
    Eigen::Index joint;
    std::size_t fault_node;  // of faults_
  };
  struct DriveAt {
    std::unique_ptr<SimNode> node;
    SimMotor* motor;  // the same object
    Eigen::Index joint;
    double joint_torque_per_motor_Nm;
    std::size_t fault_node;
  };

  /// An input node with the bits of all buttons on it.
  struct ButtonsAt {
    std::unique_ptr<SimButtonNode> node;
    std::size_t bus;
  };

  SimCanPort& add_port(std::size_t bus);
  void add_encoder(const EncoderParams& params, const std::optional<NodeProfile>& profile,
                   double heartbeat_s);
  void add_drive(const DriveParams& params, const std::optional<NodeProfile>& profile, double heartbeat_s);
  void add_button(const ButtonParams& params, double heartbeat_s);
  void press_buttons(double motion_time) noexcept;
  Eigen::Index joint_named(const std::string& name) const;
  JointTarget hand_at(double motion_time) noexcept;
  JointTarget invert(const MotionSample& target) noexcept;
  void show_joints() noexcept;

  RigParams params_;
  const Motion& motion_;
  KinematicTree tree_;
  InverseKinematics ik_;
  std::size_t ik_target_ = 0;  // the motion's body that ik_ follows
  bool reachable_ = true;
  std::vector<std::unique_ptr<Bus>> buses_;
  std::vector<CanBus*> host_buses_;
  FaultInjector faults_;
  std::vector<EncoderAt> encoders_;
  std::vector<DriveAt> drives_;
  std::vector<ButtonsAt> buttons_;
  std::unique_ptr<SimPlant> plant_;
  BusObserver observer_;
};

}  // namespace godobject
