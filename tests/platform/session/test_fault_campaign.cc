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
