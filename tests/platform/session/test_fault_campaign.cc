// Each fault of a simulated rig in each state of a run, then random sequences of faults and requests. The
// torque keeps its limits and is zero in time, and a run arms on request only.
#include <gtest/gtest.h>

#include <array>
#include <random>
#include <string>
#include <vector>

#include "tests/support/faulted_run.h"
#include "tests/support/nightly.h"
#include "tests/support/share.h"
#include "tests/support/shrunk.h"

namespace godobject::test::test_fault_campaign {
namespace {

constexpr std::array requests{"start",   "stop",  "quick stop", "hold", "release", "deadlines missed",
                              "restart", "repair"};

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

/// Starts a run and waits until its rig is in this state.
bool boot(FaultedRun& run, RigState state) {
  run.start();
  run.cycles(1);
  return run.reaches([&] { return run.rig_state() == state; });
}

/// Ends an armed run and waits until it is in this state.
bool stop(FaultedRun& run, RigState state) {
  if (!arm(run)) return false;
  run.session->stop();
  return run.reaches([&] { return run.is(state); });
}

constexpr std::array states{
    State{"off", [](FaultedRun& run) { return run.is(RigState::off); }},
    State{"booting", [](FaultedRun& run) { return boot(run, RigState::booting); }},
    State{"enabling", [](FaultedRun& run) { return boot(run, RigState::enabling); }},
    State{"settling",
          [](FaultedRun& run) {
            const auto is_enabled = [&] {
              const Nanoseconds now = run.session->bus_time_ns();
              return run.session->rig()->drive_feedback(1, now).state == MotorState::enabled;
            };
            return boot(run, RigState::enabling) && run.reaches(is_enabled);
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
    State{"stopping", [](FaultedRun& run) { return stop(run, RigState::stopping); }},
    State{"stopping at once",
          [](FaultedRun& run) {
            if (!arm(run)) return false;
            run.session->quick_stop();
            return run.is(RigState::stopping);
          }},
    State{"closing", [](FaultedRun& run) { return stop(run, RigState::closing); }},
    State{"ended", [](FaultedRun& run) { return stop(run, RigState::ended); }},
};

/// Returns the faults that a scene's devices can have.
std::vector<FaultReaction> faults_of(const SceneConfig& scene) {
  std::vector<FaultReaction> faults;
  for (const FaultReaction& reaction : fault_reactions(*scene.device->rig, FaultyRig::period_s)) {
    std::string error;
    const std::optional<FaultConfig> config = parse_fault(reaction.words, error);
    if (config && resolve(*config, *scene.device->rig).fault) faults.push_back(reaction);
  }
  return faults;
}

/// Campaign over the drives of a protocol.
class FaultCampaign : public testing::TestWithParam<DriveProtocol> {
 protected:
  static SceneConfig scene() {
    switch (GetParam()) {
      case DriveProtocol::odrive: return two_joints(DriveProtocol::odrive, DriveWatchdog::drive);
      case DriveProtocol::moteus: return two_joints(DriveProtocol::moteus, DriveWatchdog::host);
      default: return two_joints();
    }
  }
  /// True if a drive no longer receives commands. A second host of moteus sends their identifiers with other
  /// data, so both hosts' frames are destroyed.
  static bool stops_by_watchdog(const FaultReaction& fault) {
    const bool collides = GetParam() == DriveProtocol::moteus && fault.words == "second-host";
    return fault.motors == MotorsEnd::watchdog || collides;
  }

  const SceneConfig scene_ = scene();
  const std::vector<FaultReaction> faults_ = faults_of(scene_);
};
INSTANTIATE_TEST_SUITE_P(, FaultCampaign,
                         testing::Values(DriveProtocol::cia402, DriveProtocol::odrive, DriveProtocol::moteus),
                         [](const auto& of) {
                           return std::string(drive_protocol_names[static_cast<std::size_t>(of.param)]);
                         });

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

TEST_P(FaultCampaign, EveryFaultInEveryState) {
  Share share;
  std::size_t num_runs = 0;
  for (const State& state : states)
    for (const FaultReaction& fault : faults_) {
      if (!share.takes()) continue;
      FaultedRun run(scene_);
      ASSERT_TRUE(state.enter(run)) << state.name;
      if (!stops_by_watchdog(fault)) run.most_cycles_to_zero = FaultedRun::ramp_cycles;
      run.apply(fault.words);
      run.cycles(150);
      if (state.name == std::string("off")) run.start();
      run.cycles(150);
      const std::string why_not = why_not_again(run);
      EXPECT_EQ(run.broken + why_not, "") << fault << " in " << state.name;
      ++num_runs;
    }
  std::printf("%zu faults in %zu states: %zu runs\n", faults_.size(), states.size(), num_runs);
}

// ---- random sequences ------------------------------------------------------------------------------

struct Event {
  std::string words;
  int cycles_after = 0;
};

std::string broken_by(const SceneConfig& scene, const std::vector<Event>& path) {
  FaultedRun run(scene);
  if (!arm(run)) return "does not boot";
  for (const Event& event : path) {
    run.apply(event.words);
    run.cycles(event.cycles_after);
  }
  const std::string why_not = why_not_again(run);
  return run.broken.empty() ? why_not : run.broken;
}

TEST_P(FaultCampaign, RandomSequencesOfFaultsAndRequests) {
  constexpr std::size_t most_events = 20;
  const int num_sequences = length_of(GetParam() == DriveProtocol::cia402 ? 500 : 100, 500);
  std::mt19937 random(1);
  const auto below = [&](std::size_t n) {
    return std::uniform_int_distribution<std::size_t>(0, n - 1)(random);
  };
  Share share;
  std::size_t num_events = 0;
  for (int i = 0; i < num_sequences; ++i) {
    std::vector<Event> path(1 + below(most_events));
    for (Event& event : path) {
      event.words = below(2) == 0 ? requests[below(requests.size())] : faults_[below(faults_.size())].words;
      event.cycles_after = static_cast<int>(below(8) == 0 ? below(1000) : below(60));
    }
    if (!share.takes()) continue;
    num_events += path.size();
    const std::string broken = broken_by(scene_, path);
    if (broken.empty()) continue;
    std::string text;
    for (const Event& event : shrunk(path, [&](const auto& p) { return broken_by(scene_, p) == broken; }))
      text += "\n  " + event.words + ", then " + std::to_string(event.cycles_after) + " cycles";
    FAIL() << broken << ":" << text;
  }
  std::printf("%d sequences, %zu events\n", num_sequences, num_events);
}

}  // namespace
}  // namespace godobject::test::test_fault_campaign
