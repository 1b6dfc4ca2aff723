// A rig in fault still reads its buses: later faults are named too, with all their places.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/faulty_rig.h"

namespace godobject::test_fault_places {
namespace {

using testing::HasSubstr;
using testing::Not;

std::string text_after(const std::string& words, int cycles) {
  test::FaultyRig device;
  EXPECT_TRUE(device.boot()) << device.rig.fault_text();
  device.play(words);
  device.cycles(cycles);
  return device.rig.fault_text();
}

TEST(FaultPlaces, HeartbeatOfAnUnpluggedNodeIsMissedAfterItsSamples) {
  const std::string text = text_after("unplug bus=can0 node=1", 700);
  EXPECT_THAT(text, HasSubstr("sample_stale (can0 node 1, encoder of turret)"));
  EXPECT_THAT(text, HasSubstr("heartbeat_lost (can0 node 1, encoder of turret)"));
  EXPECT_THAT(text, Not(HasSubstr("node 2")));
}

TEST(FaultPlaces, BootUpMessageIsSeenAfterTheSamplesStayedAway) {
  const std::string text = text_after("reboot-node bus=can0 node=2 duration=0.2", 400);
  EXPECT_THAT(text, HasSubstr("sample_stale (can0 node 2, encoder of elbow)"));
  EXPECT_THAT(text, HasSubstr("node_restarted (can0 node 2, encoder of elbow)"));
}

TEST(FaultPlaces, TwoBusesThatAreGoneAreBothNamed) {
  const std::string text = text_after("bus-off", 10);
  EXPECT_THAT(text, HasSubstr("bus_down (can0)"));
  EXPECT_THAT(text, HasSubstr("bus_down (can1)"));
}

TEST(FaultPlaces, EveryNodeOfAnUnpluggedBusIsNamed) {
  const std::string text = text_after("unplug", 120);
  EXPECT_THAT(text, HasSubstr("sample_stale (can0 node 1, encoder of turret)"));
  EXPECT_THAT(text, HasSubstr("sample_stale (can0 node 2, encoder of elbow)"));
  EXPECT_THAT(text, HasSubstr("drive_silent (can1 node 1, drive of turret)"));
  EXPECT_THAT(text, HasSubstr("drive_silent (can1 node 2, drive of elbow)"));
}

}  // namespace
}  // namespace godobject::test_fault_places
