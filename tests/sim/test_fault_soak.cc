// Faults at random, one after the other, for a long time of the bus: each is seen, named as documented and recovered
// from, with the motors at zero within the watchdog's time. GODOBJECT_SOAK_SECONDS sets how long, in bus time;
// 3600 is the hour of the release.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <map>

#include "sim/random.h"
#include "tests/support/fault_reactions.h"
#include "tests/support/faulty_rig.h"

namespace godobject::test_fault_soak {
namespace {

using test::FaultReaction;
using test::FaultyRig;

double soak_seconds() {
  const char* const text = std::getenv("GODOBJECT_SOAK_SECONDS");
  return text ? std::atof(text) : 30;
}

/// Ends all that is active and brings every controller back on its bus.
void repair(FaultyRig& device) {
  device.link.rig().faults().clear(device.t_sync_ns);
  device.play("restart");
  for (const char* const words : {"restart bus=can0 node=1", "restart bus=can0 node=2",
                                  "restart bus=can1 node=1", "restart bus=can1 node=2"})
    device.play(words);
}

void expect_no_fault(FaultyRig& device, int cycles) {
  EXPECT_FALSE(device.cycles_to_fault(cycles)) << device.rig.fault_text();
  EXPECT_GT(device.motor_torque(), 0);
}

void expect_fault(FaultyRig& device, const FaultReaction& reaction) {
  EXPECT_TRUE(device.cycles_to_fault(reaction.within)) << "no fault came up";
  EXPECT_TRUE(any(device.rig.faults() & reaction.expected)) << device.rig.fault_text();
  EXPECT_TRUE(device.cycles_to_zero(test::cycles_of_watchdog)) << device.motor_torque() << " N m";
}

TEST(FaultSoak, EveryFaultIsSeenNamedAndRecoveredFrom) {
  FaultyRig device;
  ASSERT_TRUE(device.boot());
  Random random(20260);
  const auto below = [&](std::size_t n) {
    return static_cast<std::size_t>(random.uniform() * static_cast<double>(n));
  };
  std::map<std::string, int> played;
  while (device.motion_time < soak_seconds() && !testing::Test::HasFailure()) {
    const FaultReaction& reaction = test::fault_reactions[below(test::fault_reactions.size())];
    SCOPED_TRACE(std::string(reaction.words) + " at " + std::to_string(device.motion_time) + " s");
    expect_no_fault(device, 1 + static_cast<int>(below(200)));
    ++played[reaction.words];
    device.play(reaction.words);
    if (reaction.expected == RigFault::none) expect_no_fault(device, 50 + static_cast<int>(below(200)));
    else expect_fault(device, reaction);
    device.cycles(static_cast<int>(below(100)));
    repair(device);
    device.cycles(20);  // 128 times 11 bits take 1.4 ms
    if (device.rig.state() != RigState::fault) continue;
    EXPECT_EQ(device.motor_torque(), 0);
    device.rig.clear_faults(device.t_sync_ns);
    EXPECT_TRUE(device.boot()) << device.rig.fault_text();
  }
  int faults = 0;
  for (const auto& [words, count] : played) faults += count;
  std::printf("%.0f s of bus time, %d faults of %zu kinds\n", device.motion_time, faults, played.size());
  EXPECT_EQ(played.size(), test::fault_reactions.size()) << "too short to play each";
}

}  // namespace
}  // namespace godobject::test_fault_soak
