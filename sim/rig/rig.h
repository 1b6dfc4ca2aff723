// The simulated rig a scene describes: wires, encoder and drive nodes on them, the mechanics under them and
// the hand that moves it. The other end of the buses is a Rig that knows nothing of this.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "hal/canopen/node_profile.h"
#include "hal/joint/inverse_kinematics.h"
#include "hal/rig/bus_load.h"
#include "hal/rig/link.h"
#include "hal/rig/simulation.h"
#include "sim/fault/injector.h"
#include "sim/hand.h"
#include "sim/node/button.h"
#include "sim/node/encoder.h"
#include "sim/rig/plant.h"

namespace godobject {

struct SimRigConfig {
  RigParams rig;  // valid
  PlantConfig plant;
  WireConfig wire;
  std::vector<FaultConfig> faults;  // those that name a tracker are not for a rig
  bool shows_force = false;  // its drives' torque is felt; otherwise the mechanics follow the hand exactly
  std::size_t target = 0;    // of the hand: what the first handle follows where it does not move the joints
  RigProfiles
      devices{};  // the nodes are the devices that these profiles are for: 1000h, 1018h, unit of 6076h
};

class SimRig {
 public:
  /// Why a rig with this tree, which must be valid, cannot follow the hand; empty when it can. Poses need inverse
  /// kinematics, which not every device has; a hand that moves the joints does for all of them.
  static std::string why_not(const KinematicTreeParams& tree, const Hand& hand);

  /// why_not() is empty. profiles: what the nodes have been set up by and have stored; without, it is for the host to
  /// do. Allocates; nothing later does.
  SimRig(const SimRigConfig& config, std::shared_ptr<const Hand> hand, const RigProfiles& profiles = {});
  SimRig(const SimRig&) = delete;
  SimRig& operator=(const SimRig&) = delete;

  /// The host's port on each bus, open.
  std::span<CanBus* const> host_buses() const noexcept { return host_buses_; }
  void set_observer(const BusObserver& observer) noexcept;

  /// Runs the wires and the nodes up to t.
  void run_wires(Nanoseconds t) noexcept;
  /// When run_wires() has something to do again; none when nothing is under way.
  std::optional<Nanoseconds> next_event() const noexcept;
  /// Begins and ends the faults that are due, and moves the mechanics to t under the torque the drives apply now; the
  /// hand is where it is at motion_time (s).
  void run_plant(Nanoseconds t, double motion_time) noexcept;

  /// The config's faults are scheduled in it.
  FaultInjector& faults() noexcept { return faults_; }
  const FaultInjector& faults() const noexcept { return faults_; }
  /// Port of the node of an encoder or drive; null where there is none of this id.
  const SimCanPort* node_port(std::size_t bus, std::uint8_t node_id) const noexcept;
  /// An open port for one more node on a bus. Allocates: set-up.
  SimCanPort& attach(std::size_t bus) { return add_port(bus); }
  SimCanPort& host_port(std::size_t bus) noexcept { return buses_[bus]->host; }
  /// At the motor's shaft, by the drive of this index.
  double applied_torque_Nm(std::size_t drive) const noexcept {
    return drives_[drive].motor->applied_torque_Nm();
  }

  /// Where the handle of this index really is, and how it moves: what the encoders measure.
  Target handle(std::size_t index) const noexcept;
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
  void add_encoder(const EncoderParams& e, const std::optional<NodeProfile>& device,
                   const std::optional<NodeProfile>& stored, double heartbeat_s);
  void add_drive(const DriveParams& d, const std::optional<NodeProfile>& device,
                 const std::optional<NodeProfile>& stored, double heartbeat_s);
  void add_button(const ButtonParams& b, double heartbeat_s);
  void press_buttons(double motion_time) noexcept;
  Eigen::Index joint_named(const std::string& name) const;
  JointTarget hand_at(double motion_time) noexcept;
  JointTarget invert(const Target& target) noexcept;
  void show_joints() noexcept;

  RigParams params_;
  std::shared_ptr<const Hand> hand_;
  KinematicTree tree_;
  InverseKinematics ik_;
  std::size_t ik_target_ = 0;  // of the hand: what ik_ follows
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
