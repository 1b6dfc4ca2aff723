// Each fault of a simulated rig in each state of a run, then random sequences of faults and requests. The
// torque keeps its limits and is zero in time, and a run arms on request only.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "tests/support/fault_reactions.h"
#include "tests/support/faulty_rig.h"
#include "tests/support/nightly.h"
#include "tests/support/share.h"
#include "tests/support/shrunk.h"

namespace godobject::test::test_fault_campaign {
namespace {

constexpr int ramp_cycles = 5 + 3;  // 0.1 N m at 20 N m/s, and 3 cycles
constexpr int boot_cycles = 3000;

constexpr std::array requests{"start",   "stop",  "quick stop", "hold", "release", "deadlines missed",
                              "restart", "repair"};

/// A run on a simulated rig, and the promises that hold in every period.
class FaultedRun {
 public:
  FaultedRun() {
    SceneConfig scene = two_joints();
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
  RigState rig_state() const { return session->rig()->state(); }
  double motor_torque_Nm() const {
    double largest = 0;
    for (std::size_t i = 0; i < drives().size(); ++i)
      largest = std::max(largest, std::abs(link_->rig().applied_torque_Nm(i)));
    return largest;
  }

  std::unique_ptr<Session> session;
  std::string broken;  // the first broken promise

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
      if (!commands && std::abs(torque_Nm) > std::abs(before_Nm_[i])) fail("torque rises unarmed");
      before_Nm_[i] = torque_Nm;
    }
    if (cycles_without_ > ramp_cycles + cycles_of_watchdog && motor_torque_Nm() != 0)
      fail("torque after the watchdog");
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

// ---- each fault in each state ----------------------------------------------------------------------

struct State {
  const char* name;
  bool (*enter)(FaultedRun& run);  // returns false if the state cannot be reached
};

bool arm(FaultedRun& run) {
  run.start();
  if (!run.reaches([&] { return run.is(RigState::armed); })) return false;
  run.cycles(300);  // the force has risen
  return run.is(RigState::armed) && run.motor_torque_Nm() > 0;
}

constexpr std::array states{
    State{"off", [](FaultedRun& run) { return run.is(RigState::off); }},
    State{"booting",
          [](FaultedRun& run) {
            run.start();
            run.cycles(1);
            return run.rig_state() == RigState::booting;
          }},
    State{"enabling",
          [](FaultedRun& run) {
            run.start();
            return run.reaches([&] { return run.rig_state() == RigState::enabling; });
          }},
    State{"settling",
          [](FaultedRun& run) {
            run.start();
            return run.reaches([&] { return run.rig_state() == RigState::enabling; }) && run.reaches([&] {
              return run.session->rig()->drive_feedback(1, run.session->bus_time_ns()).state ==
                     MotorState::enabled;
            });
          }},
    State{"armed", arm},
    State{"hold",
          [](FaultedRun& run) {
            if (!arm(run)) return false;
            run.session->hold(true);
            run.cycles(3);
            return run.is(RigState::hold);
          }},
    State{"fault",
          [](FaultedRun& run) {
            if (!arm(run)) return false;
            run.session->deadlines_missed();
            run.cycles(1);
            return run.is(RigState::fault) && run.motor_torque_Nm() > 0;
          }},
    State{"stopping",
          [](FaultedRun& run) {
            if (!arm(run)) return false;
            run.session->stop();
            run.cycles(1);
            return run.is(RigState::stopping);
          }},
    State{"stopping at once",
          [](FaultedRun& run) {
            if (!arm(run)) return false;
            run.session->quick_stop();
            return run.is(RigState::stopping);
          }},
    State{"closing",
          [](FaultedRun& run) {
            if (!arm(run)) return false;
            run.session->stop();
            return run.reaches([&] { return run.is(RigState::closing); });
          }},
    State{"ended",
          [](FaultedRun& run) {
            if (!arm(run)) return false;
            run.session->stop();
            return run.reaches([&] { return run.is(RigState::ended); });
          }},
};

std::vector<std::string> all_faults() {
  std::vector<std::string> words;
  for (const FaultReaction& reaction : fault_reactions(*two_joints().device->rig, FaultyRig::period_s))
    words.push_back(reaction.words);
  return words;
}

/// Ends a run and its faults, then starts it again. Returns the reason if it does not end, or does not arm.
std::string why_not_again(FaultedRun& run) {
  run.session->hold(false);
  run.session->stop();
  if (!run.reaches([&] { return run.is(RigState::ended); })) return "does not end";
  run.repair();
  run.cycles(300);
  if (!run.is(RigState::ended)) return "does not stay at its end";
  if (run.motor_torque_Nm() != 0) return "torque at the end";
  run.session->restart();
  run.cycles(50);
  if (!run.is(RigState::off)) return "does not wait for its start";
  run.start();
  if (!run.reaches([&] { return run.is(RigState::armed) || run.is(RigState::ended); }))
    return "does not boot";
  return run.is(RigState::armed) ? "" : "does not arm again: " + run.session->rig()->fault_text();
}

TEST(FaultCampaign, EveryFaultInEveryState) {
  const std::vector<std::string> faults = all_faults();
  Share share;
  std::size_t num_runs = 0;
  for (const State& state : states)
    for (const std::string& words : faults) {
      if (!share.takes()) continue;
      FaultedRun run;
      ASSERT_TRUE(state.enter(run)) << state.name;
      run.apply(words);
      run.cycles(150);
      if (state.name == std::string("off")) run.start();
      run.cycles(150);
      const std::string why_not = why_not_again(run);
      EXPECT_EQ(run.broken + why_not, "") << words << " in " << state.name;
      ++num_runs;
    }
  std::printf("%zu faults in %zu states: %zu runs\n", faults.size(), states.size(), num_runs);
}

// ---- random sequences ------------------------------------------------------------------------------

struct Event {
  std::string words;
  int cycles_after = 0;
};

std::string broken_by(const std::vector<Event>& path) {
  FaultedRun run;
  if (!arm(run)) return "does not boot";
  for (const Event& event : path) {
    run.apply(event.words);
    run.cycles(event.cycles_after);
  }
  const std::string why_not = why_not_again(run);
  return run.broken.empty() ? why_not : run.broken;
}

TEST(FaultCampaign, RandomSequencesOfFaultsAndRequests) {
  constexpr std::size_t most_events = 20;
  const std::vector<std::string> faults = all_faults();
  const int num_sequences = length_of(50, 500);
  std::mt19937 random(1);
  const auto below = [&](std::size_t n) {
    return std::uniform_int_distribution<std::size_t>(0, n - 1)(random);
  };
  Share share;
  std::size_t num_events = 0;
  for (int i = 0; i < num_sequences; ++i) {
    std::vector<Event> path(1 + below(most_events));
    for (Event& event : path) {
      event.words = below(2) == 0 ? requests[below(requests.size())] : faults[below(faults.size())];
      event.cycles_after = static_cast<int>(below(8) == 0 ? below(1000) : below(60));
    }
    if (!share.takes()) continue;
    num_events += path.size();
    const std::string broken = broken_by(path);
    if (broken.empty()) continue;
    std::string text;
    for (const Event& event : shrunk(path, [&](const auto& p) { return broken_by(p) == broken; }))
      text += "\n  " + event.words + ", then " + std::to_string(event.cycles_after) + " cycles";
    FAIL() << broken << ":" << text;
  }
  std::printf("%d sequences, %zu events\n", num_sequences, num_events);
}

}  // namespace
}  // namespace godobject::test::test_fault_campaign
