#include "platform/cli/simulation.h"

#include <algorithm>
#include <cmath>

#include "hal/canopen.h"

namespace godobject {
namespace {

/// With no SYNC for so many periods the mechanics run by themselves.
constexpr int periods_without_sync = 5;

double seconds(Nanoseconds t) noexcept { return 1e-9 * static_cast<double>(t); }

}  // namespace

Simulation::Simulation(const SceneConfig& scene, const Motion& motion, std::vector<OfferedBus> buses,
                       bool motion_waits_for_sync)
    : params_(*scene.device->rig),
      period_ns_(std::llround(1e9 * scene.step)),
      buses_(std::move(buses)),
      rig_(scene, motion),
      motors_(params_.drives.size()) {
  for (const OfferedBus& offered : buses_) {
    SimCanPort& port = offered.is_tap ? rig_.attach(offered.wire) : rig_.host_port(offered.wire);
    bridges_.emplace_back(*offered.bus, port);
  }
  if (!motion_waits_for_sync) t_motion_ns_ = 0;
}

void Simulation::step(Nanoseconds now) noexcept {
  rig_.run_wires(now);
  now_ns_ = now;
  take_frames();
  const bool alone = now - t_sync_ns_ >= periods_without_sync * period_ns_;
  if (alone && now - t_plant_ns_ >= period_ns_) run_plant();
  rig_.run_wires(now);  // what came in takes part in the next arbitration
  for (BusBridge& bridge : bridges_) bridge.forward(now);
  watch_motors();
}

void Simulation::take_frames() noexcept {
  CanFrame frame;
  std::uint8_t counter = 0;
  for (BusBridge& bridge : bridges_) {
    while (bridge.try_take(frame)) {
      if (canopen::parse_sync(frame, counter) == ParseResult::ok) on_sync();
      bridge.deliver(frame);
    }
  }
}

// Positions are those of the time of the SYNC; that of the next bus, which follows at once, changes nothing.
void Simulation::on_sync() noexcept {
  ++syncs_;
  t_sync_ns_ = now_ns_;
  if (!t_motion_ns_) t_motion_ns_ = now_ns_;
  if (2 * (now_ns_ - t_plant_ns_) >= period_ns_) run_plant();
}

void Simulation::run_plant() noexcept {
  rig_.run_plant(now_ns_, motion_time());
  t_plant_ns_ = now_ns_;
}

void Simulation::watch_motors() noexcept {
  for (std::size_t i = 0; i < motors_.size(); ++i) {
    MotorWatch& motor = motors_[i];
    motor.torque_Nm = rig_.applied_torque_Nm(i);
    motor.max_torque_Nm = std::max(motor.max_torque_Nm, std::abs(motor.torque_Nm));
    if (motor.torque_Nm != 0) motor.t_nonzero_s = seconds(now_ns_);
  }
}

Nanoseconds Simulation::next_event() const noexcept {
  const bool alone = now_ns_ - t_sync_ns_ >= periods_without_sync * period_ns_;
  const Nanoseconds t_plant_ns =
      alone ? t_plant_ns_ + period_ns_ : t_sync_ns_ + periods_without_sync * period_ns_;
  return std::min(t_plant_ns, rig_.next_event().value_or(t_plant_ns));
}

double Simulation::motion_time() const noexcept {
  return t_motion_ns_ ? seconds(now_ns_ - *t_motion_ns_) : 0;
}

std::vector<int> Simulation::descriptors() const {
  std::vector<int> out;
  for (const OfferedBus& offered : buses_) out.push_back(offered.bus->descriptor());
  return out;
}

nlohmann::ordered_json Simulation::to_json() const {
  using json = nlohmann::ordered_json;
  json out{{"t_s", seconds(now_ns_)},
           {"motion_s", motion_time()},
           {"syncs", syncs_},
           {"reachable", rig_.reachable()},
           {"faults_begun", rig_.faults().begun()}};
  for (std::size_t i = 0; i < buses_.size(); ++i) {
    const BridgeCounters& c = bridges_[i].counters();
    out["buses"].push_back({{"name", buses_[i].name},
                            {"address", buses_[i].address},
                            {"tap", buses_[i].is_tap},
                            {"trouble", buses_[i].bus->trouble()},
                            {"from_bus", c.from_bus},
                            {"to_bus", c.to_bus},
                            {"refused", c.refused},
                            {"dropped", c.dropped}});
  }
  out["drives"] = json::array();
  for (std::size_t i = 0; i < motors_.size(); ++i)
    out["drives"].push_back({{"bus", params_.buses[params_.drives[i].bus].name},
                             {"node", params_.drives[i].node_id},
                             {"joint", params_.drives[i].joint},
                             {"torque_Nm", motors_[i].torque_Nm},
                             {"max_torque_Nm", motors_[i].max_torque_Nm},
                             {"nonzero_at_s", motors_[i].t_nonzero_s}});
  out["faults"] = json::array();
  for (const ActiveFault& active : rig_.faults().active()) {
    json fault{{"verb", text_of(active.fault.verb).name},
               {"node", active.fault.node_id},
               {"value", active.fault.value}};
    if (active.fault.end_bus == active.fault.first_bus + 1)
      fault["bus"] = params_.buses[active.fault.first_bus].name;
    if (active.t_end_ns) fault["ends_at_s"] = seconds(*active.t_end_ns);
    out["faults"].push_back(fault);
  }
  return out;
}

}  // namespace godobject
