// Messages about an interface's settings, and frames in the kernel's layout; needs no CAN.
#include <gtest/gtest.h>

#include <cerrno>
#include <cstring>

#include "platform/linux/bus/socket_can.h"

namespace godobject::test::test_link {
namespace {

CanLink controller_at(std::uint32_t bit_rate, std::uint32_t data_bit_rate = 0) {
  CanLink link{.up = true, .mtu = data_bit_rate > 0 ? 72u : 16u, .transmit_queue_length = 10};
  link.controller = {.bit_rate = bit_rate, .data_bit_rate = data_bit_rate, .restart_ms = 100};
  return link;
}

TEST(CanLink, BitRatesAreComparedWithinTheToleranceOfOscillators) {
  const BusSettings expected{.bit_rate = 1e6};
  EXPECT_EQ(fit(controller_at(1'000'000), expected), LinkFit::fits);
  EXPECT_EQ(fit(controller_at(998'000), expected), LinkFit::fits);
  EXPECT_EQ(fit(controller_at(500'000), expected), LinkFit::bit_rate);
  EXPECT_EQ(fit(controller_at(0), expected), LinkFit::bit_rate);
}

TEST(CanLink, DataBitRatesCountWhereCanFdIsExpected) {
  const BusSettings expected{.bit_rate = 1e6, .data_bit_rate = 5e6};
  EXPECT_EQ(fit(controller_at(1'000'000, 5'000'000), expected), LinkFit::fits);
  EXPECT_EQ(fit(controller_at(1'000'000, 2'000'000), expected), LinkFit::data_bit_rate);
  EXPECT_EQ(fit(controller_at(1'000'000), expected), LinkFit::classic_only);
  EXPECT_EQ(fit(controller_at(1'000'000, 2'000'000), {.bit_rate = 1e6}), LinkFit::fits);
}

TEST(CanLink, AVirtualInterfaceHasNoBitRateToBeWrong) {
  EXPECT_EQ(fit({.up = true, .mtu = 72}, {.bit_rate = 1e6, .data_bit_rate = 5e6}), LinkFit::fits);
  EXPECT_EQ(fit({.up = false, .mtu = 72}, {}), LinkFit::down);
}

TEST(CanLink, EveryMisfitComesWithTheCommand) {
  const BusSettings settings{.bit_rate = 1e6, .data_bit_rate = 5e6};
  const CanLink link = controller_at(500'000);
  EXPECT_EQ(text_of(LinkFit::fits, "can0", link, settings), "");
  EXPECT_EQ(
      text_of(LinkFit::down, "can0", link, settings),
      "can0 is down: ip link set can0 up type can bitrate 1000000 dbitrate 5000000 fd on restart-ms 100");
  for (const LinkFit misfit : {LinkFit::bit_rate, LinkFit::data_bit_rate, LinkFit::classic_only})
    EXPECT_NE(text_of(misfit, "can0", link, settings)
                  .find("ip link set can0 down && ip link set can0 up type can "),
              std::string::npos);
}

TEST(CanLink, NothingIsWrongWithAGoodOne) {
  EXPECT_EQ(link_warnings("can0", controller_at(1'000'000)), "");
  CanLink link = controller_at(1'000'000);
  link.controller->restart_ms = 0;
  std::ranges::copy("fq_codel", link.qdisc.begin());
  const std::string warnings = link_warnings("can0", link);
  EXPECT_NE(warnings.find("type can restart-ms 100"), std::string::npos);
  EXPECT_NE(warnings.find("tc qdisc replace dev can0 root pfifo_fast"), std::string::npos);
}

TEST(CanLink, OtherInterfacesAreToldFromMissingOnes) {
  CanLink link;
  EXPECT_EQ(read_can_link("lo", link), EMEDIUMTYPE);
  EXPECT_EQ(read_can_link("no-such-one", link), ENODEV);
  EXPECT_EQ(read_can_link("a-name-that-is-too-long", link), ENODEV);
  EXPECT_EQ(read_can_link("", link), ENODEV);
}

TEST(SocketCanFrame, LayoutIsTheKernels) {
  KernelFrame out;
  EXPECT_EQ(to_kernel({.id = 0x123, .size = 2, .data = {0xAA, 0xBB}}, out), std::size_t{CAN_MTU});
  can_frame classic;
  std::memcpy(&classic, &out, sizeof classic);
  EXPECT_EQ(classic.can_id, 0x123u);
  EXPECT_EQ(classic.len, 2);
  EXPECT_EQ(classic.data[1], 0xBB);
  EXPECT_EQ(to_kernel({.id = 0x123, .extended = true, .remote = true}, out), std::size_t{CAN_MTU});
  EXPECT_EQ(out.can_id, 0x123u | CAN_EFF_FLAG | CAN_RTR_FLAG);
  EXPECT_EQ(to_kernel({.id = 1, .fd = true, .bit_rate_switch = true, .size = 64}, out),
            std::size_t{CANFD_MTU});
  EXPECT_EQ(out.flags, CANFD_BRS);
}

TEST(SocketCanFrame, WhatIsNoFrameIsRefused) {
  KernelFrame in{};
  for (const std::size_t size : {std::size_t{0}, std::size_t{15}, std::size_t{17}, std::size_t{71}})
    EXPECT_FALSE(from_kernel(in, size)) << size;
  in.len = 9;
  EXPECT_FALSE(from_kernel(in, CAN_MTU));
  EXPECT_TRUE(from_kernel(in, CANFD_MTU));
  in.len = 65;
  EXPECT_FALSE(from_kernel(in, CANFD_MTU));
}

}  // namespace
}  // namespace godobject::test::test_link
