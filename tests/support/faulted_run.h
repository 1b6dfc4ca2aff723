// A run on a simulated rig that has faults, and the promises that hold in every period.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/fault_reactions.h"
#include "tests/support/faulty_rig.h"

namespace godobject::test {

/// A run on a simulated rig, and the promises that hold in every period.
class FaultedRun {
 public:
  static constexpr int ramp_cycles = 5 + 3;  // 0.1 N m at 20 N m/s, and 3 cycles
  static constexpr int boot_cycles = 3000;

  explicit FaultedRun(const SceneConfig& scene = two_joints()) {
    const std::shared_ptr<const Hand> hand = hand_of(Motion(scene));
    auto link = std::make_unique<SimLink>(sim_rig_config(scene), scene.step, hand, FaultyRig::poll_ns,
                                          profiles_of(scene));
    link_ = link.get();
    DeviceParts device;
    device.truth = std::make_unique<SimulatedTruth>(scene, hand, link_);
    device.buses = std::move(link);
    const Motion motion(scene);
    Session::Made made = Session::make(scene, motion, std::move(device));
    session = std::move(made.session);
    record_ = session->at_start();
    before_Nm_.assign(drives().size(), 0);
  }

  /// Applies a request, or injects a fault in words such as "drop bus=can0 node=1".
  void apply(const std::string& event) {
    if (event == "start") start();
    else if (event == "stop") session->stop();
    else if (event == "quick stop") session->quick_stop();
    else if (event == "hold" || event == "release") session->hold(event == "hold");
    else if (event == "deadlines missed") session->deadlines_missed();
    else if (event == "restart") session->restart();
    else if (event == "repair") repair();
    else play(event);
  }
  void start() {
    is_requested_ = is_requested_ || session->state() == RigState::off;
    session->start(usual_boot_limit_s);
  }
  /// Ends all faults and restarts every controller.
  void repair() {
    link_->rig().faults().clear(now_ns_);
    // Torques that waited in a controller while its bus was unplugged are sent now. A moteus that was powered
    // again meanwhile, or a drive that another host kept enabled, follows them until its watchdog.
    if (drives().front().protocol != DriveProtocol::cia402) cycles_without_ = 0;
    for (const char* const words : {"restart", "restart bus=can0 node=1", "restart bus=can0 node=2",
                                    "restart bus=can1 node=1", "restart bus=can1 node=2"})
      play(words);
  }
  void cycles(int count) {
    for (int i = 0; i < count; ++i) cycle();
  }
  /// Runs periods until the condition holds; returns false if it does not within `limit`.
  template <class Condition>
  bool reaches(Condition&& holds, int limit = boot_cycles) {
    for (int i = 0; i < limit; ++i) {
      if (holds()) return true;
      cycle();
    }
    return holds();
  }
  bool is(RigState state) const { return session->state() == state; }
  const CycleRecord& record() const { return record_; }
  const SimRig& device() const { return link_->rig(); }
  RigState rig_state() const { return session->rig()->state(); }
  double motor_torque_Nm() const {
    double largest = 0;
    for (std::size_t i = 0; i < drives().size(); ++i)
      largest = std::max(largest, std::abs(link_->rig().applied_torque_Nm(i)));
    return largest;
  }

  std::unique_ptr<Session> session;
  std::string broken;  // the first broken promise
  /// Periods within which motors without a command have no torque: those of a drive that receives nothing.
  int most_cycles_to_zero = ramp_cycles + cycles_of_watchdog;

 private:
  const std::vector<DriveParams>& drives() const { return session->scene().device->rig->drives; }
  void play(const std::string& words) {
    std::string error;
    const std::optional<FaultConfig> config = parse_fault(words, error);
    const FaultResult found = config ? resolve(*config, *session->scene().device->rig) : FaultResult{};
    if (!found.fault) throw std::runtime_error(words + ": " + error + found.error);
    static_cast<void>(link_->rig().faults().schedule(*found.fault));  // of too many the last are left out
  }

  void cycle() {
    const Nanoseconds t_ns = session->bus_time_ns();
    static_cast<void>(session->advance(record_));
    now_ns_ = session->bus_time_ns();
    // Before its start and after its end a run leaves the buses alone, whose time goes on.
    if (now_ns_ == t_ns) {
      now_ns_ = link_->begin_cycle(record_.t);
      for (CanBus* const bus : session->host_buses())
        for (ReceivedFrame unread; bus->try_receive(unread);) continue;
    }
    check();
  }
  void check() {
    const RigState state = session->state();
    const bool is_armed = state == RigState::armed || state == RigState::hold;
    if (is_armed && !is_requested_) fail("armed without a request");
    if (state == RigState::fault || state >= RigState::stopping) is_requested_ = false;
    if (state == RigState::armed && session->rig()->faults() != RigFault::none) fail("armed with a fault");
    const bool commands = is_armed && rig_state() == RigState::armed;
    cycles_without_ = commands ? 0 : cycles_without_ + 1;
    for (std::size_t i = 0; i < drives().size(); ++i) {
      const DriveParams& drive = drives()[i];
      const double torque_Nm = session->rig()->commanded_torque_Nm(i);
      const double most_Nm = drive.torque_rate_Nm_per_s * session->scene().step * (1 + 1e-9);
      if (std::abs(torque_Nm) > drive.torque_max_Nm) fail("torque above its limit");
      if (std::abs(link_->rig().applied_torque_Nm(i)) > drive.torque_max_Nm * (1 + 1e-3))
        fail("torque of the motor above its limit");
      if (torque_Nm != 0 && std::abs(torque_Nm - before_Nm_[i]) > most_Nm) fail("torque above its rate");
      // a torque for a moteus leaves with the next cycle's request, before that cycle sees a fault
      const int sent_after = drive.protocol == DriveProtocol::moteus ? 1 : 0;
      if (cycles_without_ > sent_after && std::abs(torque_Nm) > std::abs(before_Nm_[i]))
        fail("torque rises unarmed");
      before_Nm_[i] = torque_Nm;
    }
    if (cycles_without_ > most_cycles_to_zero && motor_torque_Nm() != 0) fail("torque beyond its time");
  }
  void fail(const char* promise) {
    if (broken.empty()) broken = promise;
  }

  SimLink* link_ = nullptr;
  CycleRecord record_;
  Nanoseconds now_ns_ = 0;
  std::vector<double> before_Nm_;  // commanded in the period before
  bool is_requested_ = false;      // start() was called, and armed not left since
  int cycles_without_ = 0;         // periods since the drives were commanded to display a force
};

}  // namespace godobject::test
