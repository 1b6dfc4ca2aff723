#include "platform/cli/simulate/simulation.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <limits>

#include "hal/canopen/canopen.h"
#include "hal/drive/link.h"
#include "platform/linux/serial_port.h"
#include "platform/simulated/session.h"

namespace godobject {
namespace {

/// Number of periods without SYNC after which the mechanics run by themselves.
constexpr int periods_without_sync = 5;
/// Longest time without SYNC of a host that does not boot again.
constexpr Nanoseconds longest_gap_ns = 100'000'000;
/// Longest time between two steps, so that holds are measured.
constexpr Nanoseconds longest_step_ns = 1'000'000;

double seconds(Nanoseconds t) noexcept { return 1e-9 * static_cast<double>(t); }

using json = nlohmann::ordered_json;

json error_of(const std::string& why) { return {{"ok", false}, {"error", why}}; }

json play(std::string_view words, Simulation& simulation) {
  std::string what;
  const std::optional<FaultConfig> config = parse_fault(words, what);
  if (config) what = simulation.play(*config);
  if (!what.empty()) return error_of(what);
  return {{"ok", true}, {"t_s", 1e-9 * static_cast<double>(simulation.now())}};
}

}  // namespace

bool BusBridge::try_take(CanFrame& frame) noexcept {
  ReceivedFrame received;
  if (!bus_.try_receive(received)) return false;
  frame = received.frame;
  ++counters_.from_bus;
  return true;
}

void BusBridge::deliver(const CanFrame& frame) noexcept {
  if (port_.try_send(frame) != SendResult::queued) ++counters_.refused;
}

void BusBridge::forward(Nanoseconds now) noexcept {
  for (;;) {
    if (!waiting_) {
      ReceivedFrame received;
      if (!port_.try_receive(received)) return;
      waiting_ = received.frame;
      t_waiting_ns_ = now;
    }
    const SendResult result = bus_.try_send(*waiting_);
    if (result == SendResult::full && now - t_waiting_ns_ < patience_ns) return;
    ++(result == SendResult::queued ? counters_.to_bus : counters_.dropped);
    waiting_.reset();
  }
}

TrackerLine::~TrackerLine() {
  if (slave_fd_ >= 0) close(slave_fd_);
}

std::string TrackerLine::open() {
  const Pty pty = make_pty();
  if (!pty.why.empty()) return pty.why;
  slave_fd_ = pty.slave;
  port_.adopt(pty.master, pty.name);
  return "";
}

void TrackerLine::step(Nanoseconds now) noexcept {
  std::array<std::uint8_t, 512> in{};
  while (const std::size_t size = port_.read(in)) {
    num_received_ += size;
    far_->receive({in.data(), size}, now);
  }
  far_->advance(now);
  for (;;) {
    if (unsent_.empty()) unsent_ = {out_.data(), far_->transmit(out_, now)};
    if (unsent_.empty()) return;
    const std::size_t taken = port_.write(unsent_);
    unsent_ = unsent_.subspan(taken);
    if (taken == 0) return;
  }
}

Simulation::Simulation(const SceneConfig& scene, const RigProfiles& devices, const Motion& motion,
                       std::vector<OfferedBus> buses, bool motion_waits_for_sync,
                       std::vector<std::unique_ptr<TrackerLine>> trackers)
    : params_(scene.device->rig.value_or(RigParams{})),
      tracker_params_(scene.device->trackers),
      period_ns_(to_ns(scene.step)),
      buses_(std::move(buses)),
      motors_(params_.drives.size()),
      trackers_(std::move(trackers)) {
  const std::shared_ptr<const Hand> hand = hand_of(motion);
  if (scene.device->rig) {
    SimRigConfig config = sim_rig_config(scene);
    config.devices = devices;
    rig_.emplace(config, scene.step, hand);
  }
  for (const OfferedBus& offered : buses_) {
    SimCanPort& port = offered.is_tap ? rig_->attach(offered.wire) : rig_->host_port(offered.wire);
    bridges_.emplace_back(*offered.bus, port);
  }
  std::vector<SimTracker*> far;
  for (const std::unique_ptr<TrackerLine>& tracker : trackers_) far.push_back(&tracker->far());
  if (!far.empty()) tools_.emplace(sim_trackers_config(scene), hand, std::move(far));
  if (!motion_waits_for_sync) start_motion();
}

void Simulation::step(Nanoseconds wall_ns) noexcept {
  const Nanoseconds now = clock_.advance(wall_ns, next_event());
  if (rig_) run_rig(now);
  if (tools_) run_trackers();
}

void Simulation::run_rig(Nanoseconds now) noexcept {
  rig_->run_wires(now);
  take_frames();
  const bool alone = now - t_sync_ns_ >= periods_without_sync * period_ns_;
  if (alone && now - t_plant_ns_ >= period_ns_) run_plant();
  rig_->run_wires(now);  // received frames take part in the next arbitration
  for (BusBridge& bridge : bridges_) bridge.forward(now);
  watch_motors();
}

void Simulation::run_trackers() noexcept {
  tools_->run(now(), motion_time());
  for (const std::unique_ptr<TrackerLine>& tracker : trackers_) {
    tracker->step(now());
    if (!rig_ && !t_motion_ns_ && tracker->num_received() > 0) t_motion_ns_ = now();
  }
}

std::string Simulation::play(const FaultConfig& config) {
  bool is_scheduled = false;
  if (!config.tracker.empty()) {
    const TrackerFaultResult found = resolve(config, tracker_params_);
    if (!found.fault) return found.error;
    is_scheduled = tools_->schedule(*found.fault);
  } else {
    const FaultResult found = resolve(config, params_);
    if (!found.fault) return found.error;
    is_scheduled = rig_->faults().schedule(*found.fault);
  }
  return is_scheduled ? "" : "too many faults are active: clear some";
}

void Simulation::clear_faults() noexcept {
  if (rig_) rig_->faults().clear(now());
  if (tools_) tools_->clear();
}

void Simulation::take_frames() noexcept {
  CanFrame frame;
  std::uint8_t counter = 0;
  for (std::size_t i = 0; i < bridges_.size(); ++i) {
    while (bridges_[i].try_take(frame)) {
      if (canopen::parse_sync(frame, counter) == ParseResult::ok) on_sync();
      watch_commands(buses_[i].wire, frame);
      bridges_[i].deliver(frame);
    }
  }
}

void Simulation::watch_commands(std::size_t bus, const CanFrame& frame) noexcept {
  const std::uint8_t node = bus_protocol(protocol_of_bus(params_, bus)).commanded(frame);
  for (std::size_t i = 0; i < motors_.size(); ++i)
    if (params_.drives[i].bus == bus && params_.drives[i].node_id == node)
      motors_[i].t_commanded_s = seconds(now());
}

// Positions are those at the time of the SYNC. The SYNC of the next bus follows at once and changes nothing.
void Simulation::on_sync() noexcept {
  const bool is_first = !t_motion_ns_ || now() - t_sync_ns_ >= longest_gap_ns;
  ++syncs_;
  t_sync_ns_ = now();
  if (is_first) start_motion();
  if (2 * (now() - t_plant_ns_) >= period_ns_) run_plant();
}

void Simulation::run_plant() noexcept {
  rig_->run_plant(now(), motion_time());
  t_plant_ns_ = now();
}

void Simulation::watch_motors() noexcept {
  for (std::size_t i = 0; i < motors_.size(); ++i) {
    MotorWatch& motor = motors_[i];
    const bool had_torque = motor.torque_Nm != 0;
    motor.torque_Nm = rig_->applied_torque_Nm(i);
    motor.max_torque_Nm = std::max(motor.max_torque_Nm, std::abs(motor.torque_Nm));
    if (motor.torque_Nm != 0 || had_torque) motor.t_nonzero_s = seconds(now());
  }
}

Nanoseconds Simulation::next_event() const noexcept {
  const Nanoseconds t_latest_ns = now() + longest_step_ns;
  if (!rig_) return t_latest_ns;
  const bool alone = now() - t_sync_ns_ >= periods_without_sync * period_ns_;
  const Nanoseconds t_plant_ns =
      alone ? t_plant_ns_ + period_ns_ : t_sync_ns_ + periods_without_sync * period_ns_;
  return std::min({t_plant_ns, rig_->next_event().value_or(t_plant_ns), t_latest_ns});
}

/// Starts the motion. A hand that homes the device holds it before, also for each later boot of the host.
void Simulation::start_motion() noexcept {
  if (!t_motion_ns_) t_motion_ns_ = now();
  if (!rig_ || !rig_->hand_homes()) return;
  motion_held_s_ = motion_time();
  *t_motion_ns_ += to_ns(HomingHand::usual_time_s);
}

double Simulation::motion_time() const noexcept {
  return t_motion_ns_ ? std::max(seconds(now() - *t_motion_ns_), motion_held_s_) : 0;
}

std::vector<int> Simulation::descriptors() const {
  std::vector<int> out;
  for (const OfferedBus& offered : buses_) out.push_back(offered.bus->descriptor());
  for (const std::unique_ptr<TrackerLine>& tracker : trackers_) out.push_back(tracker->descriptor());
  return out;
}

nlohmann::ordered_json Simulation::to_json() const {
  using json = nlohmann::ordered_json;
  json out{{"t_s", seconds(now())},
           {"held_s", seconds(clock_.held())},
           {"motion_s", motion_time()},
           {"syncs", syncs_},
           {"sync_at_s", seconds(t_sync_ns_)},
           {"reachable", !rig_ || rig_->reachable()},
           {"faults_begun", (rig_ ? rig_->faults().begun() : 0) + (tools_ ? tools_->begun() : 0)}};
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
  out["bus_off"] = bus_off_json();
  out["drives"] = json::array();
  for (std::size_t i = 0; i < motors_.size(); ++i)
    out["drives"].push_back({{"bus", params_.buses[params_.drives[i].bus].name},
                             {"node", params_.drives[i].node_id},
                             {"joint", params_.drives[i].joint},
                             {"torque_Nm", motors_[i].torque_Nm},
                             {"max_torque_Nm", motors_[i].max_torque_Nm},
                             {"nonzero_at_s", motors_[i].t_nonzero_s},
                             {"commanded_at_s", motors_[i].t_commanded_s}});
  out["trackers"] = json::array();
  for (const std::unique_ptr<TrackerLine>& tracker : trackers_)
    out["trackers"].push_back({{"name", tracker->name()},
                               {"port", tracker->path()},
                               {"bytes_from_host", tracker->num_received()},
                               {"lost_messages", tracker->far().lost_messages()}});
  out["faults"] = faults_json();
  return out;
}

/// Lists the nodes in bus-off.
nlohmann::ordered_json Simulation::bus_off_json() const {
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  for (std::size_t bus = 0; bus < params_.buses.size(); ++bus)
    for (std::uint8_t id = 1; id <= canopen::max_node_id; ++id) {
      const SimCanPort* const port = rig_->node_port(bus, id);
      if (port == nullptr || port->state() != BusState::bus_off) continue;
      out.push_back({{"bus", params_.buses[bus].name}, {"node", id}});
    }
  return out;
}

nlohmann::ordered_json Simulation::faults_json() const {
  using json = nlohmann::ordered_json;
  json out = json::array();
  for (const ActiveFault& active : rig_ ? rig_->faults().active() : std::span<const ActiveFault>{}) {
    json fault{{"verb", text_of(active.fault.verb).name},
               {"node", active.fault.node_id},
               {"value", active.fault.value},
               {"begun_at_s", seconds(active.t_begin_ns)}};
    if (active.fault.end_bus == active.fault.first_bus + 1)
      fault["bus"] = params_.buses[active.fault.first_bus].name;
    if (active.t_end_ns) fault["ends_at_s"] = seconds(*active.t_end_ns);
    out.push_back(fault);
  }
  for (const SimTrackers::Active& active :
       tools_ ? tools_->active() : std::span<const SimTrackers::Active>{}) {
    json fault{{"verb", text_of(active.fault.verb).name},
               {"tracker", tracker_params_[active.fault.tracker].name},
               {"value", active.fault.value}};
    if (active.t_end_ns) fault["ends_at_s"] = seconds(*active.t_end_ns);
    out.push_back(fault);
  }
  return out;
}

// ---- commands --------------------------------------------------------------------------------------

std::string answer(std::string_view command, Simulation& simulation, bool& quit) {
  if (command.size() >= LineInput::max_line)
    return error_of("longer than " + std::to_string(LineInput::max_line - 1) + " bytes: the line was ignored")
        .dump();
  const std::size_t space = command.find(' ');
  const std::string_view verb = command.substr(0, space);
  json reply{{"ok", true}};
  if (verb == "fault" && space != std::string_view::npos) {
    reply = play(command.substr(space + 1), simulation);
  } else if (verb == "clear") {
    simulation.clear_faults();
  } else if (verb == "status") {
    reply.update(simulation.to_json());
  } else if (verb == "quit") {
    quit = true;
  } else {
    reply =
        error_of(std::string(command) +
                 ": expected fault VERB [bus=NAME] [node=ID] [tracker=NAME] [value=X] [duration=S] [at=S], "
                 "clear, status or "
                 "quit");
  }
  return reply.dump(-1, ' ', false, json::error_handler_t::replace);  // replaces bytes that are not UTF-8
}

LineInput::LineInput(int descriptor) noexcept
    : descriptor_(descriptor), former_flags_(fcntl(descriptor, F_GETFL)) {
  fcntl(descriptor, F_SETFL, former_flags_ | O_NONBLOCK);
}

LineInput::~LineInput() { fcntl(descriptor_, F_SETFL, former_flags_); }

bool LineInput::try_line(std::string& line) {
  std::array<char, 256> buffer{};
  while (!ended_ && text_.find('\n') == std::string::npos && text_.size() < max_line) {
    const ssize_t size = ::read(descriptor_, buffer.data(), buffer.size());
    if (size < 0 && errno == EINTR) continue;
    if (size < 0 && errno == EAGAIN) return false;
    if (size <= 0) ended_ = true;
    else text_.append(buffer.data(), static_cast<std::size_t>(size));
  }
  const std::size_t found = text_.find('\n'), end = std::min(found, text_.size());
  if (text_.empty()) return false;
  if (skips_) {  // skip the rest of a line whose beginning was answered
    text_.erase(0, end + 1);
    skips_ = found == std::string::npos && !ended_;
    return try_line(line);
  }
  line = text_.substr(0, end);
  text_.erase(0, end + 1);
  skips_ = found == std::string::npos && !ended_;
  return true;
}

}  // namespace godobject
