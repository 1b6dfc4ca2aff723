#include "platform/rig/buses.h"

#include <gtest/gtest.h>

#include "hal/canopen/canopen.h"

namespace godobject::test_rig_filters {
namespace {

RigParams rig() {
  RigParams params;
  params.buses = {{.name = "can0"}, {.name = "can1"}};
  params.encoders = {{.joint = "a", .bus = 0, .node_id = 5}};
  params.drives = {{.joint = "a", .bus = 0, .node_id = 9},
                   {.joint = "b", .protocol = DriveProtocol::odrive, .bus = 1, .node_id = 3},
                   {.joint = "c", .protocol = DriveProtocol::moteus, .bus = 1, .node_id = 4},
                   {.joint = "d", .protocol = DriveProtocol::moteus, .bus = 1, .node_id = 64}};
  params.buttons = {{.bus = 1, .node_id = 17}};
  return params;
}

bool passes_on(std::size_t bus, std::uint32_t id, bool extended = false) {
  const std::vector<std::vector<CanFilter>> filters = rig_filters(rig());
  return passes(filters[bus], CanFrame{.id = id, .extended = extended});
}

TEST(RigFilters, PassEverythingOfTheRigsNodes) {
  for (const std::uint32_t node : {5u, 9u})
    for (const std::uint32_t function : {0x080u, 0x180u, 0x200u, 0x280u, 0x580u, 0x600u, 0x700u})
      EXPECT_TRUE(passes_on(0, function + node)) << std::hex << function + node;
  for (std::uint32_t command = 0; command < 32; ++command) EXPECT_TRUE(passes_on(1, 3u << 5 | command));
  EXPECT_TRUE(passes_on(1, 0x400)) << "moteus 4 to the host";
  EXPECT_TRUE(passes_on(1, 0x8004, true)) << "the host to moteus 4";
  EXPECT_TRUE(passes_on(1, 0x4000, true)) << "moteus 64 to the host";
  EXPECT_TRUE(passes_on(1, 0x191)) << "buttons";
}

TEST(RigFilters, PassTheHostsOwnFrames) {
  for (const std::size_t bus : {0u, 1u}) {
    EXPECT_TRUE(passes_on(bus, canopen::make_sync().id));
    EXPECT_TRUE(passes_on(bus, canopen::make_nmt(canopen::NmtCommand::start, 5).id));
    EXPECT_TRUE(passes_on(bus, canopen::heartbeat_cob_id(rig().host_node_id)));
  }
}

TEST(RigFilters, LeaveOutTheRest) {
  EXPECT_FALSE(passes_on(0, 0x186));
  EXPECT_FALSE(passes_on(0, 0x706));
  EXPECT_FALSE(passes_on(0, 5, true));
  EXPECT_FALSE(passes_on(0, 0x191)) << "the button is on the other bus";
  EXPECT_FALSE(passes_on(1, 5u << 5));
  EXPECT_FALSE(passes_on(1, 0x8005, true));
}

}  // namespace
}  // namespace godobject::test_rig_filters
