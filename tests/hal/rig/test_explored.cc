// Every reachable state of a rig, its drive and its link, with every event: breadth first, over the real
// code and a scripted device. States that differ in timers only count as one. Then random sequences.
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <deque>
#include <fstream>
#include <memory>
#include <random>
#include <set>
#include <sstream>
#include <vector>

#include "tests/support/share.h"
#include "tests/support/shrunk.h"
#include "tests/support/supervised_rig.h"

namespace godobject::test_explored {
namespace {

using cia402::DriveState;
using test::input_id;
using test::num_incremental_rig_trials;
using test::num_rig_trials;
using test::RigTrial;
using test::shrunk;
using test::SupervisedRig;
using testing::HasSubstr;

using Path = std::vector<RigTrial>;

std::string text_of(const Path& path) {
  std::string text;
  for (const RigTrial event : path)
    text += std::string(" ") + test::rig_trial_names[static_cast<std::size_t>(event)];
  return text;
}

/// Returns the events from first on, but not `last`.
Path events_from(RigTrial first, int last) {
  Path events;
  for (int i = static_cast<int>(first); i < last; ++i) events.push_back(static_cast<RigTrial>(i));
  return events;
}

std::unique_ptr<SupervisedRig> world_after(const RigParams& params, const Path& path) {
  auto world = std::make_unique<SupervisedRig>(params);
  for (const RigTrial event : path) world->apply(event);
  return world;
}

struct Explored {
  std::size_t num_states = 0;
  std::set<RigState> rig_states;
};

constexpr std::size_t all_states = 10'000;

/// Visits every state that the events lead to, breadth first. most_states: number of states in which every
/// event acts; the first ones.
Explored explore(const RigParams& params, const Path& events, std::size_t most_states = all_states) {
  Explored out;
  std::deque<Path> open{{}};
  std::set<decltype(SupervisedRig{}.key())> seen{SupervisedRig(params).key()};
  for (std::size_t n = 0; n < most_states && !open.empty(); ++n) {
    const Path path = open.front();
    open.pop_front();
    for (const RigTrial next : events) {
      Path longer = path;
      longer.push_back(next);
      const std::unique_ptr<SupervisedRig> world = world_after(params, longer);
      out.rig_states.insert(world->rig.state());
      EXPECT_EQ(world->broken, "") << "after the events" << text_of(longer);
      if (!world->broken.empty()) return out;
      if (seen.insert(world->key()).second) open.push_back(longer);
    }
  }
  out.num_states = seen.size();
  return out;
}

std::string document() {
  std::ifstream file(GODOBJECT_SOURCE_DIR "/docs/faults.md");
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

/// States of the table that the events of a rig lead to. The others are states of a run. is_incremental:
/// true if the rig waits for the home pose.
std::set<RigState> states_of_a_rig(bool is_incremental) {
  constexpr std::array events{
      RigEvent::start, RigEvent::nodes_up,   RigEvent::homed, RigEvent::drives_up, RigEvent::arm,
      RigEvent::fault, RigEvent::quick_stop, RigEvent::clear, RigEvent::disarm,    RigEvent::switch_off};
  std::set<RigState> seen{RigState::off};
  for (std::size_t before = 0; before != seen.size();) {
    before = seen.size();
    for (const RigState state : std::set(seen))
      for (const RigEvent event : events)
        if (const auto after = next({.state = state}, event)) seen.insert(after->state);
  }
  if (!is_incremental) seen.erase(RigState::homing);
  return seen;
}

class ExploredDrive : public testing::TestWithParam<DriveProtocol> {};

TEST_P(ExploredDrive, EveryStateOfRigDriveAndLinkKeepsThePromises) {
  constexpr std::size_t usual = 200;  // states
  const bool is_whole = GetParam() == DriveProtocol::cia402 || std::getenv("GODOBJECT_NIGHTLY") != nullptr;
  const Explored explored =
      explore(test::params_of_rig_with(GetParam()), events_from(RigTrial::start, num_rig_trials),
              is_whole ? all_states : usual);
  EXPECT_EQ(explored.rig_states, states_of_a_rig(false));
  if (!is_whole) return;
  EXPECT_THAT(document(), HasSubstr(std::to_string(explored.num_states) + " states (" +
                                    drive_protocol_names[static_cast<std::size_t>(GetParam())] + ")"));
  EXPECT_THAT(document(), HasSubstr(std::to_string(num_rig_trials) + " events"));
}

INSTANTIATE_TEST_SUITE_P(Explored, ExploredDrive,
                         testing::Values(DriveProtocol::cia402, DriveProtocol::odrive, DriveProtocol::moteus),
                         [](const auto& drive) {
                           return drive_protocol_names[static_cast<std::size_t>(drive.param)];
                         });

// Only the requests and the events of the encoder; the random sequences have all events.
TEST(Explored, EveryStateOfAnIncrementalRigKeepsThePromises) {
  const Path events{RigTrial::start,
                    RigTrial::arm,
                    RigTrial::clear,
                    RigTrial::deadlines_missed,
                    RigTrial::encoder_unplugged,
                    RigTrial::encoder_plugged,
                    RigTrial::encoder_restarts,
                    RigTrial::cycle,
                    RigTrial::wait,
                    RigTrial::press_home,
                    RigTrial::release_home,
                    RigTrial::move};
  const Explored explored = explore(test::params_of_incremental_rig(), events);
  EXPECT_EQ(explored.rig_states, states_of_a_rig(true));
  EXPECT_THAT(document(), HasSubstr(std::to_string(explored.num_states) + " states with " +
                                    std::to_string(events.size()) + " events"));
}

TEST(FaultCampaign, CounterExamplesAreShrunk) {
  const Path path{RigTrial::start, RigTrial::bus_off, RigTrial::wait, RigTrial::arm, RigTrial::cycle};
  const auto breaks = [](const Path& p) {
    const auto off = std::ranges::find(p, RigTrial::bus_off);
    return std::find(off, p.end(), RigTrial::arm) != p.end();
  };
  EXPECT_EQ(shrunk(path, breaks), (Path{RigTrial::bus_off, RigTrial::arm}));
}

/// Plays random sequences of the rig's events after `begin`; often it plays the requests instead.
void play_random(const RigParams& params, int num_events, const Path& begin, const Path& requests) {
  const auto broken_by = [&](const Path& path) { return world_after(params, path)->broken; };
  constexpr int num_sequences = 500, most_events = 20;
  std::mt19937 random(1);
  const auto below = [&](std::size_t n) {
    return std::uniform_int_distribution<std::size_t>(0, n - 1)(random);
  };
  test::Share share;
  for (int i = 0; i < num_sequences; ++i) {
    Path path = begin;
    const std::size_t length = 1 + below(most_events);
    for (std::size_t k = 0; k < length; ++k)
      path.push_back(below(3) == 0 ? requests[below(requests.size())]
                                   : static_cast<RigTrial>(below(static_cast<std::size_t>(num_events))));
    if (!share.takes()) continue;
    const std::string broken = broken_by(path);
    if (broken.empty()) continue;
    const Path shortest = shrunk(path, [&](const Path& p) { return !broken_by(p).empty(); });
    FAIL() << broken << ":" << text_of(shortest);
  }
}

TEST_P(ExploredDrive, RandomSequencesKeepThePromises) {
  play_random(test::params_of_rig_with(GetParam()), num_rig_trials,
              {RigTrial::start, RigTrial::wait, RigTrial::arm},
              {RigTrial::clear, RigTrial::wait, RigTrial::arm});
}

TEST(FaultCampaign, RandomSequencesOfAnIncrementalRigKeepThePromises) {
  play_random(test::params_of_incremental_rig(), num_incremental_rig_trials,
              {RigTrial::start, RigTrial::wait, RigTrial::press_home, RigTrial::wait, RigTrial::arm},
              {RigTrial::clear, RigTrial::wait, RigTrial::arm, RigTrial::release_home, RigTrial::press_home});
}

/// Applies events in turn.
void apply(SupervisedRig& world, std::initializer_list<RigTrial> events) {
  for (const RigTrial event : events) world.apply(event);
}

TEST(EmergencyStopInput, RemovesTheTorqueInTheSameCycle) {
  SupervisedRig world;
  apply(world, {RigTrial::start, RigTrial::wait, RigTrial::arm, RigTrial::cycle, RigTrial::cycle});
  ASSERT_NE(world.rig.commanded_torque_Nm(0), 0);
  world.apply(RigTrial::press_stop);
  EXPECT_EQ(world.rig.state(), RigState::fault);
  EXPECT_EQ(world.rig.torque_output(), TorqueOutput::at_once);
  EXPECT_EQ(world.device.torque_per_mille, 0);
  EXPECT_NE(world.device.drive, DriveState::operation_enabled);
  const RigFaultRecord record = world.rig.fault_log().first(RigFault::quick_stop);
  EXPECT_EQ(record.place.node_id, input_id);
  EXPECT_EQ(world.rig.faults(), RigFault::quick_stop);
}

TEST(EmergencyStopInput, IsClearedAfterItsReleaseOnly) {
  SupervisedRig world;
  apply(world, {RigTrial::start, RigTrial::wait, RigTrial::arm, RigTrial::press_stop, RigTrial::wait,
                RigTrial::clear});
  EXPECT_EQ(world.rig.state(), RigState::fault) << "still pressed";
  apply(world, {RigTrial::release_stop, RigTrial::wait});
  EXPECT_EQ(world.rig.state(), RigState::fault) << "not cleared";
  apply(world, {RigTrial::clear, RigTrial::wait});
  EXPECT_EQ(world.rig.state(), RigState::ready) << "not armed without a request";
  EXPECT_EQ(world.broken, "");
}

TEST(EmergencyStopInput, ActsWhileAnotherFaultRunsDown) {
  SupervisedRig world;
  apply(world, {RigTrial::start, RigTrial::wait, RigTrial::arm, RigTrial::wait, RigTrial::deadlines_missed});
  ASSERT_NE(world.rig.commanded_torque_Nm(0), 0);
  world.apply(RigTrial::press_stop);
  EXPECT_EQ(world.rig.commanded_torque_Nm(0), 0);
  EXPECT_EQ(world.rig.torque_output(), TorqueOutput::at_once);
}

}  // namespace
}  // namespace godobject::test_explored
