#include "hal/rig/bus_load.h"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

namespace godobject::test_bus_load {
namespace {

constexpr double cycle_s = 1e-3;
constexpr BusLoadParams cyclic_only{
    .heartbeat_period_s = 0, .drive_event_period_s = 0, .button_event_period_s = 0};

RigParams rig_of(int num_encoders, int num_drives) {
  RigParams rig;
  rig.buses.push_back({.name = "can0"});
  for (int i = 0; i < num_encoders; ++i) {
    EncoderParams encoder;
    encoder.joint = "e";
    encoder.node_id = static_cast<std::uint8_t>(1 + i);
    rig.encoders.push_back(encoder);
  }
  for (int i = 0; i < num_drives; ++i) {
    DriveParams drive;
    drive.joint = "d";
    drive.node_id = static_cast<std::uint8_t>(32 + i);
    rig.drives.push_back(drive);
  }
  return rig;
}

// SYNC, N encoders and M motors: 1 kHz at 1 Mbit/s, in tenths of a percent, and the rate at 100 % worst case.
TEST(BusLoad, IsTheHandbooksTable) {
  struct Row {
    int encoders, drives;
    double nominal, worst;
    int max_rate_hz;
  };
  const Row rows[] = {{1, 0, 12.6, 15.0, 6666}, {2, 0, 20.5, 24.5, 4081}, {4, 0, 36.3, 43.5, 2298},
                      {6, 0, 52.1, 62.5, 1600}, {1, 1, 31.6, 38.0, 2631}, {2, 1, 39.5, 47.5, 2105},
                      {3, 1, 47.4, 57.0, 1754}, {2, 2, 58.5, 70.5, 1418}, {4, 2, 74.3, 89.5, 1117},
                      {6, 1, 71.1, 85.5, 1169}, {3, 3, 85.4, 103.0, 970}, {6, 2, 90.1, 108.5, 921}};
  for (const Row& row : rows) {
    const auto loads = bus_load(rig_of(row.encoders, row.drives), cycle_s, cyclic_only);
    ASSERT_EQ(loads.size(), 1u);
    EXPECT_NEAR(loads[0].nominal_percent, row.nominal, 1e-9);
    EXPECT_NEAR(loads[0].worst_percent, row.worst, 1e-9);
    EXPECT_EQ(static_cast<int>(1000 * 100 / loads[0].worst_percent), row.max_rate_hz);
  }
}

TEST(BusLoad, CountsStatusEveryNthSyncHeartbeatsAndEvents) {
  RigParams rig = rig_of(1, 1);
  rig.drives[0].status_every_nth_sync = 4;
  const BusLoad load = bus_load(rig, cycle_s, {.heartbeat_period_s = 0.05, .drive_event_period_s = 0.02})[0];
  // SYNC 55, position 95, command 95, status 135 / 4 per ms; event 125 per 20 ms; three heartbeats 65 per 50
  // ms.
  EXPECT_NEAR(load.worst_percent, 0.1 * (55 + 95 + 95 + 135 / 4.0 + 125 / 20.0 + 3 * 65 / 50.0), 1e-9);
  EXPECT_EQ(load.messages.size(), 8u);
}

TEST(BusLoad, SplitsTheRigByBusAndSortsByPriority) {
  RigParams rig = rig_of(2, 1);
  rig.buses.push_back({.name = "can1", .bit_rate = 500e3});
  rig.encoders[1].bus = 1;
  const auto loads = bus_load(rig, cycle_s, cyclic_only);
  ASSERT_EQ(loads.size(), 2u);
  EXPECT_NEAR(loads[0].worst_percent, 0.1 * (55 + 95 + 95 + 135), 1e-9);
  EXPECT_EQ(loads[1].bus, "can1");
  EXPECT_NEAR(loads[1].worst_percent, 0.2 * (55 + 95), 1e-9);
  const std::uint32_t by_priority[] = {0x080, 0x181, 0x180 + 32, 0x200 + 32};
  ASSERT_EQ(loads[0].messages.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(loads[0].messages[i].cob_id, by_priority[i]);
}

// Moteus drives at 1 kHz on 1M/5M: 24 bytes extended there, 24 bytes standard back.
TEST(BusLoad, CountsCanFdAtBothRates) {
  for (const auto& [drives, nominal, worst] :
       {std::tuple{3, 51.3, 60.6}, {4, 68.4, 80.8}, {5, 85.5, 101.0}}) {
    RigParams rig = rig_of(0, drives);
    rig.buses[0].data_bit_rate = 5e6;
    for (int i = 0; i < drives; ++i) {
      rig.drives[static_cast<std::size_t>(i)].protocol = DriveProtocol::moteus;
      rig.drives[static_cast<std::size_t>(i)].node_id = static_cast<std::uint8_t>(1 + i);
    }
    const BusLoad load = bus_load(rig, cycle_s, cyclic_only)[0];
    EXPECT_NEAR(load.nominal_percent, nominal, 0.5);
    EXPECT_NEAR(load.worst_percent, worst, 0.5);
    EXPECT_EQ(load.messages.size(), 2u * static_cast<unsigned>(drives));  // no SYNC, no heartbeats
    EXPECT_TRUE(load.messages.front().extended);                          // 8001h begins with eleven zeros
  }
}

// 23 % for a torque command and an estimate, 5.5 % for the request, and the drive's own messages.
TEST(BusLoad, CountsAnOdrivesRequest) {
  RigParams rig = rig_of(0, 1);
  rig.drives[0].protocol = DriveProtocol::odrive;
  const BusLoad load = bus_load(rig, cycle_s, {})[0];
  EXPECT_NEAR(load.worst_percent, 0.1 * (95 + 135 + 55 + 135 / 10.0 + 135 / 100.0), 1e-9);
}

TEST(BusLoad, CountsTheButtonsOfANodeOnce) {
  RigParams rig = rig_of(1, 0);
  rig.buttons = {{.node_id = 9, .bit = 0}, {.node_id = 9, .bit = 1}};
  const BusLoad load = bus_load(rig, cycle_s, {.heartbeat_period_s = 0.1, .button_event_period_s = 0.05})[0];
  EXPECT_NEAR(load.worst_percent, 0.1 * (55 + 95 + 65 / 50.0 + 3 * 65 / 100.0), 1e-9);
}

}  // namespace
}  // namespace godobject::test_bus_load
