// Simulated rig of a scene: wires, encoder and drive nodes, their mechanics and the hand that moves it. The
// Rig at the other end of the buses does not depend on it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "hal/canopen/node_profile.h"
#include "hal/joint/inverse_kinematics.h"
#include "hal/joint/transmission.h"
#include "hal/rig/bus_load.h"
#include "hal/rig/link.h"
#include "hal/rig/simulation.h"
#include "sim/fault/injector.h"
#include "sim/hand.h"
#include "sim/node/button.h"
#include "sim/node/encoder.h"
#include "sim/rig/homing_hand.h"
#include "sim/rig/plant.h"

namespace godobject {

struct SimRigConfig {
  RigParams rig;  // valid
  PlantConfig plant;
  WireConfig wire;
  std::vector<FaultConfig> faults;  // entries that name a tracker are ignored
  bool shows_force = false;         // drives act on the hand; otherwise the mechanics follow the hand exactly
  // target of the hand that the first handle follows, if it does not move the joints
  std::size_t target = 0;
  // Device profiles of the nodes: 1000h, 1018h, unit of 6076h.
  RigProfiles devices{};
};

class SimRig {
 public:
  /// Returns the reason that a rig with this tree, which must be valid, cannot follow the hand; empty if it
  /// can. Poses need inverse kinematics, which not every device permits; a hand that moves the joints works
  /// for all.
  static std::string why_not(const KinematicTreeParams& tree, const Hand& hand);

  /// why_not() must be empty. cycle_s: SYNC period of the host, s. profiles: set-up that the nodes have
  /// stored; without it, the host sets them up. Allocates, as attach() does; no other function does.
  SimRig(const SimRigConfig& config, double cycle_s, std::shared_ptr<const Hand> hand,
         const RigProfiles& profiles = {});
  SimRig(const SimRig&) = delete;
  SimRig& operator=(const SimRig&) = delete;

  /// Returns the host's port on each bus, open.
  std::span<CanBus* const> host_buses() const noexcept { return host_buses_; }
  void set_observer(const BusObserver& observer) noexcept;

  /// Runs the wires and the nodes up to t.
  void run_wires(Nanoseconds t) noexcept;
  /// Returns the next time at which run_wires() has work; nullopt if nothing is pending.
  std::optional<Nanoseconds> next_event() const noexcept;
  /// Begins and ends due faults. Advances the mechanics to t with the present drive torques and the hand at
  /// motion_time (s).
  void run_plant(Nanoseconds t, double motion_time) noexcept;

  /// Returns the injector, with the config's faults scheduled.
  FaultInjector& faults() noexcept { return faults_; }
  const FaultInjector& faults() const noexcept { return faults_; }
  /// Returns the port of an encoder or drive node; null if the id does not exist.
  const SimCanPort* node_port(std::size_t bus, std::uint8_t node_id) const noexcept;
  /// Adds an open port for another node on a bus. Allocates: set-up.
  SimCanPort& attach(std::size_t bus) { return add_port(bus); }
  SimCanPort& host_port(std::size_t bus) noexcept { return buses_[bus]->host; }
  /// Returns the torque of a drive at the motor shaft, N m. drive: index.
  double applied_torque_Nm(std::size_t drive) const noexcept {
    return drives_[drive].motor->applied_torque_Nm();
  }

  /// Returns the true pose and twist of a handle, as measured by the encoders. index: of the handle.
  Target handle(std::size_t index) const noexcept;
  /// Returns the true joint coordinates and rates.
  JointTarget joints() const noexcept { return {.q = plant_->q(), .q_dot = plant_->q_dot()}; }
  /// True while the device could reach every pose so far.
  bool reachable() const noexcept { return reachable_; }
  /// Returns the torque of the hand on a joint in the last sub-step, N m or N. joint: index.
  double hand_torque(std::size_t joint) const noexcept {
    return plant_->hand_torque()[static_cast<Eigen::Index>(joint)];
  }
  /// True if the hand homes the device before its motion.
  bool hand_homes() const noexcept { return homing_.is_used(); }
  /// Returns the mean load of a bus since the start, percent.
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
    std::size_t fault_node;  // index in faults_
  };
  struct DriveAt {
    std::unique_ptr<SimNode> node;
    SimMotor* motor;  // same object as node
    Eigen::Index joint;
    double actuator_torque_per_motor_Nm;
    std::size_t fault_node;
  };

  /// Input node with the bits of all its buttons.
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
  bool is_pressed(const ButtonParams& button, double motion_time) const noexcept;
  void press_buttons(double motion_time) noexcept;
  Eigen::Index joint_named(const std::string& name) const;
  JointTarget hand_at(double motion_time) noexcept;
  JointTarget invert(const Target& target) noexcept;
  void show_joints() noexcept;

  RigParams params_;
  double cycle_s_;
  std::shared_ptr<const Hand> hand_;
  KinematicTree tree_;
  Vec3 gravity_W_;
  Transmission transmission_;
  HomingHand homing_;
  InverseKinematics ik_;
  std::size_t ik_target_ = 0;  // target of the hand that ik_ follows
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
