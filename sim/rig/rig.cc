#include "sim/rig/rig.h"

#include <algorithm>
#include <cmath>

#include "hal/canopen/commissioning_steps.h"
#include "sim/node/drive.h"
#include "sim/node/moteus.h"
#include "sim/node/odrive.h"

namespace godobject {
namespace {

constexpr Nanoseconds ns_per_ms = 1'000'000;

/// Returns a heartbeat period of up to 2.27 times the shortest of the rig. It differs between nodes, because
/// in-phase heartbeats would always fall between the same SYNC and its answers.
Nanoseconds heartbeat_period_ns(double shortest_s, std::uint8_t node_id) noexcept {
  return std::llround(1e9 * shortest_s * (1 + 0.01 * node_id));
}

/// A drive with its two interfaces, to the wire and to the mechanics: one object.
struct MadeDrive {
  std::unique_ptr<SimNode> node;
  SimMotor* motor;
};

template <class Drive>
MadeDrive both(std::unique_ptr<Drive> drive) {
  SimMotor* const motor = drive.get();
  return {.node = std::move(drive), .motor = motor};
}

/// Returns the unit of 6076h, N m.
double unit_of(const std::optional<NodeProfile>& device) {
  return device && device->torque_rated_unit_Nm ? device->torque_rated_unit_Nm->value : torque_rated_unit_Nm;
}

// Makes a drive: one line per protocol.
MadeDrive make_drive(CanBus& bus, const DriveParams& params, const std::optional<NodeProfile>& device,
                     std::vector<SdoStep> stored, Nanoseconds heartbeat_ns) {
  switch (params.protocol) {
    case DriveProtocol::odrive: return both(std::make_unique<SimOdrive>(bus, params));
    case DriveProtocol::moteus: return both(std::make_unique<SimMoteus>(bus, params));
    case DriveProtocol::cia402: break;
  }
  const bool own_watchdog = params.watchdog == DriveWatchdog::drive;
  auto drive = std::make_unique<SimDrive>(
      bus, SimDriveParams{.drive = params,
                          .rpdo_timeout_ns = own_watchdog ? ns_per_ms * params.watchdog_ms : 0,
                          .heartbeat_period_ns = heartbeat_ns,
                          .torque_rated_unit_Nm = unit_of(device)});
  if (device) drive->identify_as(device->identity);
  drive->store(std::move(stored));
  return both(std::move(drive));
}

const std::optional<NodeProfile>& profile_of(const std::vector<std::optional<NodeProfile>>& profiles,
                                             std::size_t index) {
  static const std::optional<NodeProfile> none;
  return index < profiles.size() ? profiles[index] : none;
}

/// Returns the steps by which the host would set up the node.
std::vector<SdoStep> steps_of(const std::optional<NodeProfile>& profile, double cycle_s, NodeSetup setup) {
  if (!profile) return {};
  return commissioning_steps(*profile, cycle_s, setup);
}

}  // namespace

std::string SimRig::why_not(const KinematicTreeParams& tree, const Hand& hand) {
  if (hand.moves_joints() || InverseKinematics(tree).invertible()) return "";
  std::string joints;
  for (const DeviceJoint& joint : tree.joints) joints += (joints.empty() ? "'" : ", '") + joint.name + "'";
  return "a motion of poses on the simulated bus needs a device with one handle and six joints that all move "
         "it: give --motion a column for each joint (" +
         joints + "), or use --bus direct";
}

SimRig::SimRig(const SimRigConfig& config, double cycle_s, std::shared_ptr<const Hand> hand,
               const RigProfiles& profiles)
    : params_(config.rig),
      cycle_s_(cycle_s),
      hand_(std::move(hand)),
      tree_(params_.tree),
      gravity_W_(config.plant.gravity_W),
      transmission_(params_.transmissions, params_.tree.joints),
      homing_(params_, config.plant.hand_homes),
      ik_(params_.tree),
      ik_target_(config.target),
      faults_(config.wire.seed) {
  for (std::size_t i = 0; i < params_.buses.size(); ++i) {
    SimWireParams wire;
    const BusParams& bus = params_.buses[i];
    wire.rates = {.nominal = bus.bit_rate, .data = bus.data_bit_rate > 0 ? bus.data_bit_rate : bus.bit_rate};
    wire.corruption_probability = config.wire.corruption_probability;
    wire.seed = config.wire.seed + i;
    buses_.push_back(std::make_unique<Bus>(wire));
    buses_[i]->rig = this;
    buses_[i]->index = i;
    SimCanPort& host = buses_[i]->host;
    static_cast<void>(host.open());
    host.set_loss_probability(config.wire.loss_probability);
    host.set_receive_delay(static_cast<Nanoseconds>(config.wire.delay_s * 1e9));
    host_buses_.push_back(&host);
    faults_.add_bus(buses_[i]->wire, host, buses_[i]->nodes, params_);
  }
  const double heartbeat_s = usual_load(params_).heartbeat_period_s;
  for (std::size_t i = 0; i < params_.encoders.size(); ++i)
    add_encoder(params_.encoders[i], profile_of(config.devices.encoders, i), profile_of(profiles.encoders, i),
                heartbeat_s);
  for (std::size_t i = 0; i < params_.drives.size(); ++i)
    add_drive(params_.drives[i], profile_of(config.devices.drives, i), profile_of(profiles.drives, i),
              heartbeat_s);
  for (const ButtonParams& b : params_.buttons) add_button(b, heartbeat_s);
  std::vector<SimFault> faults;
  for (const FaultConfig& fault : config.faults)
    if (const FaultResult found = resolve(fault, params_); found.fault) faults.push_back(*found.fault);
  faults_.schedule_all(faults);
  const JointTarget start = hand_at(0);
  std::vector<JointPlant> plants;
  for (const DeviceJoint& joint : params_.tree.joints) plants.push_back(config.plant.of(joint.name));
  plant_ = std::make_unique<SimPlant>(std::move(plants), config.shows_force && !drives_.empty(), start.q, 0);
  show_joints();
  press_buttons(0);
}

void SimRig::add_encoder(const EncoderParams& e, const std::optional<NodeProfile>& device,
                         const std::optional<NodeProfile>& stored, double heartbeat_s) {
  SimCanPort& port = add_port(e.bus);
  auto node = std::make_unique<SimEncoder>(port, e.node_id, e.calibration,
                                           heartbeat_period_ns(heartbeat_s, e.node_id));
  if (device) node->identify_as(device->identity);
  node->store(steps_of(stored, cycle_s_, {.node_id = e.node_id, .host_node_id = params_.host_node_id}));
  const std::size_t fault_node = faults_.add_node(e.bus, port, *node, e.calibration);
  buses_[e.bus]->nodes.push_back(node.get());
  encoders_.push_back({.node = std::move(node), .joint = joint_named(e.joint), .fault_node = fault_node});
}

void SimRig::add_drive(const DriveParams& d, const std::optional<NodeProfile>& device,
                       const std::optional<NodeProfile>& stored, double heartbeat_s) {
  SimCanPort& port = add_port(d.bus);
  const NodeSetup setup{.node_id = d.node_id,
                        .host_node_id = params_.host_node_id,
                        .torque_rated_Nm = d.torque_rated_Nm,
                        .status_every_nth_sync = d.status_every_nth_sync};
  auto [node, motor] = make_drive(port, d, device, steps_of(stored, cycle_s_, setup),
                                  heartbeat_period_ns(heartbeat_s, d.node_id));
  const std::size_t fault_node = faults_.add_node(d.bus, port, *node, d.calibration);
  buses_[d.bus]->nodes.push_back(node.get());
  drives_.push_back({.node = std::move(node),
                     .motor = motor,
                     .joint = joint_named(d.joint),
                     .actuator_torque_per_motor_Nm = d.sign / d.joint_per_motor_rad,
                     .fault_node = fault_node});
}

void SimRig::add_button(const ButtonParams& b, double heartbeat_s) {
  const auto is_it = [&](const ButtonsAt& at) { return at.bus == b.bus && at.node->node_id() == b.node_id; };
  if (std::ranges::any_of(buttons_, is_it)) return;
  SimCanPort& port = add_port(b.bus);
  auto node = std::make_unique<SimButtonNode>(port, b.node_id, heartbeat_period_ns(heartbeat_s, b.node_id));
  static_cast<void>(faults_.add_node(b.bus, port, *node, {}));
  buses_[b.bus]->nodes.push_back(node.get());
  buttons_.push_back({.node = std::move(node), .bus = b.bus});
}

void SimRig::press_buttons(double motion_time) noexcept {
  for (const ButtonsAt& at : buttons_) {
    unsigned inputs = 0;
    for (const ButtonParams& b : params_.buttons) {
      if (b.bus != at.bus || b.node_id != at.node->node_id()) continue;
      inputs |= (is_pressed(b, motion_time) != b.active_low ? 1u : 0u) << b.bit;
    }
    at.node->set_inputs(static_cast<std::uint8_t>(inputs));
  }
}

/// True if the hand or a fault presses the button.
bool SimRig::is_pressed(const ButtonParams& button, double motion_time) const noexcept {
  if (faults_.is_pressed(button)) return true;
  switch (button.use) {
    case ButtonUse::hold: return hand_->presses_hold(motion_time);
    case ButtonUse::clutch: return hand_->presses_clutch(ik_target_, motion_time);
    case ButtonUse::home: return homing_.presses();
    case ButtonUse::stop: break;
  }
  return false;
}

const SimCanPort* SimRig::node_port(std::size_t bus, std::uint8_t node_id) const noexcept {
  return faults_.port_of(bus, node_id);
}

SimCanPort& SimRig::add_port(std::size_t bus) {
  Bus& b = *buses_[bus];
  b.ports.push_back(std::make_unique<SimCanPort>(b.wire));
  static_cast<void>(b.ports.back()->open());
  b.ports.back()->set_pdo_buffers();
  return *b.ports.back();
}

Eigen::Index SimRig::joint_named(const std::string& name) const {
  for (std::size_t i = 0; i < params_.tree.joints.size(); ++i)
    if (params_.tree.joints[i].name == name) return static_cast<Eigen::Index>(i);
  return 0;  // unreachable: validate(RigParams) refuses an unknown name
}

void SimRig::set_observer(const BusObserver& observer) noexcept {
  observer_ = observer;
  for (const auto& bus : buses_) {
    bus->wire.set_observer({.on_frame =
                                [](void* context, const ReceivedFrame& frame) {
                                  const Bus& b = *static_cast<Bus*>(context);
                                  b.rig->observer_.on_frame(b.rig->observer_.context, b.index, frame);
                                },
                            .context = bus.get()});
  }
}

JointTarget SimRig::hand_at(double motion_time) noexcept {
  JointTarget hand =
      hand_->moves_joints() ? hand_->joints(motion_time) : invert(hand_->target(ik_target_, motion_time));
  if (motion_time <= 0) hand.q_dot.setZero();  // the motion has not begun
  if (!homing_.is_used()) return hand;
  const JointTarget moved =
      homing_.moved({.q = transmission_.actuators(hand.q), .q_dot = transmission_.actuators(hand.q_dot)});
  return {.q = transmission_.joints(moved.q), .q_dot = transmission_.joints(moved.q_dot)};
}

JointTarget SimRig::invert(const Target& target) noexcept {
  const IkSolution solution = ik_.solve(target.X_WD);
  JointTarget hand{.q = solution.q, .q_dot = JointVector::Zero(solution.q.size())};
  const bool solved = solution.status == IkStatus::solved && ik_.joint_rates(target.V_WD, hand.q_dot);
  reachable_ = reachable_ && solved;
  return hand;
}

void SimRig::run_wires(Nanoseconds t) noexcept {
  for (const auto& bus : buses_) advance(bus->wire, bus->nodes, t);
}

std::optional<Nanoseconds> SimRig::next_event() const noexcept {
  Nanoseconds t = SimNode::never;
  for (const auto& bus : buses_) {
    t = std::min(t, bus->wire.next_event().value_or(SimNode::never));
    for (const SimNode* node : bus->nodes) t = std::min(t, node->next_timer());
  }
  return t == SimNode::never ? std::nullopt : std::optional(t);
}

void SimRig::run_plant(Nanoseconds t, double motion_time) noexcept {
  faults_.run(t, motion_time);
  homing_.advance(t, motion_time);
  JointVector tau = JointVector::Zero(plant_->q().size());
  for (const DriveAt& d : drives_)
    tau[d.joint] = d.motor->applied_torque_Nm() * d.actuator_torque_per_motor_Nm;
  tau = transmission_.joint_torques(tau) + tree_.at(plant_->q()).weight_torques(gravity_W_);
  for (Eigen::Index i = 0; i < tau.size(); ++i) plant_->set_motor_torque(static_cast<std::size_t>(i), tau[i]);
  const JointTarget hand = hand_at(motion_time);
  plant_->advance(t, hand.q, hand.q_dot);
  show_joints();
  press_buttons(motion_time);
}

void SimRig::show_joints() noexcept {
  const JointVector a = transmission_.actuators(plant_->q()),
                    a_dot = transmission_.actuators(plant_->q_dot());
  for (const EncoderAt& e : encoders_) faults_.move(e.fault_node, a[e.joint]);
  for (const DriveAt& d : drives_) faults_.move(d.fault_node, a[d.joint]);
  for (const EncoderAt& e : encoders_) e.node->set_position(faults_.shown(e.fault_node));
  for (const DriveAt& d : drives_) d.motor->set_joint(faults_.shown(d.fault_node), a_dot[d.joint]);
}

Target SimRig::handle(std::size_t index) const noexcept {
  const TreeConfiguration at = tree_.at(plant_->q());
  return {.X_WD = at.X_WH(index), .V_WD = at.twist(index, plant_->q_dot())};
}

double SimRig::load_percent(std::size_t bus, Nanoseconds now) const noexcept {
  return 100.0 * static_cast<double>(buses_[bus]->wire.counters().busy_ns) / static_cast<double>(now);
}

}  // namespace godobject
