// Interfaces that go down, disappear, return, or differ from the expected ones.
#include "tests/socketcan/can_test.h"

namespace godobject::test::test_interface {
namespace {

bool mentions(const std::string& text, const std::string& what) {
  return text.find(what) != std::string::npos;
}

// The one test that needs a kernel without CAN.
TEST(SocketCan, AKernelWithoutCanIsNamed) {
  const int fd = socket(PF_CAN, SOCK_RAW, CAN_RAW);
  if (fd >= 0) {
    close(fd);
    GTEST_SKIP() << "this kernel has CAN";
  }
  ASSERT_EQ(errno, EAFNOSUPPORT);
  SocketCanBus bus("can0", {});
  EXPECT_EQ(bus.trouble(), "");
  EXPECT_FALSE(bus.open());
  EXPECT_TRUE(mentions(bus.trouble(), "no SocketCAN")) << bus.trouble();
  EXPECT_EQ(bus.state(), BusState::closed);
  EXPECT_EQ(bus.descriptor(), -1);
  EXPECT_EQ(bus.try_send({.id = 1}), SendResult::down);
  ReceivedFrame received;
  EXPECT_FALSE(bus.try_receive(received));
}

TEST_F(VirtualCanTest, TheInterfaceGoesDownAndComesUpAgain) {
  ASSERT_TRUE(bus.open()) << bus.trouble();
  ASSERT_TRUE(other.open());
  set("down");
  ASSERT_TRUE(becomes_true(bus, [&] { return bus.state() == BusState::down; }));
  EXPECT_TRUE(mentions(bus.trouble(), "ip link set vcantest up")) << bus.trouble();
  EXPECT_EQ(bus.try_send({.id = 1}), SendResult::down);
  set("up");
  EXPECT_EQ(bus.try_send({.id = 1}), SendResult::queued);
  EXPECT_EQ(bus.state(), BusState::error_active);
  EXPECT_EQ(bus.trouble(), "");
  // The other bus only listens: it is up again when a frame comes.
  EXPECT_TRUE(becomes_true(other, [&] { return other.state() == BusState::error_active; }));
}

TEST_F(VirtualCanTest, AnInterfaceThatIsRenamedWhileOpenGoesOn) {
  ASSERT_TRUE(bus.open()) << bus.trouble();
  ASSERT_TRUE(other.open());
  set("down");
  for (SocketCanBus* const each : {&bus, &other})
    ASSERT_TRUE(becomes_true(*each, [&] { return each->state() == BusState::down; }));
  set("name vcanother");
  EXPECT_TRUE(mentions(bus.trouble(), "is called vcanother now")) << bus.trouble();
  ASSERT_EQ(std::system("ip link set vcanother up"), 0);
  EXPECT_EQ(other.try_send({.id = 1}), SendResult::queued);
  EXPECT_TRUE(becomes_true(bus, [&] { return bus.state() == BusState::error_active; })) << bus.trouble();
  bus.close();
  EXPECT_FALSE(bus.open());
  EXPECT_TRUE(mentions(bus.trouble(), "is called vcanother now")) << bus.trouble();
  ASSERT_EQ(std::system("ip link set vcanother down && ip link set vcanother name vcantest"), 0);
}

TEST_F(VirtualCanTest, WhatCameBeforeTheInterfaceWentDownIsStillRead) {
  ASSERT_TRUE(bus.open());
  ASSERT_TRUE(other.open());
  for (std::uint32_t id = 0; id < 5; ++id) ASSERT_EQ(other.try_send({.id = id}), SendResult::queued);
  set("down");
  EXPECT_EQ(drain(bus), 5u);
  EXPECT_EQ(bus.state(), BusState::down);
}

// Without a read in between: sending detects it.
TEST_F(VirtualCanTest, ASendNoticesThatTheInterfaceIsDown) {
  ASSERT_TRUE(bus.open());
  set("down");
  EXPECT_EQ(bus.try_send({.id = 1}), SendResult::down);
  EXPECT_EQ(bus.state(), BusState::down);
  EXPECT_EQ(bus.counters().send_refused, 1u);
}

TEST_F(VirtualCanTest, AnUnpluggedInterfaceIsOpenedAnewByItsName) {
  ASSERT_TRUE(bus.open());
  remove();
  ASSERT_TRUE(becomes_true(bus, [&] { return bus.state() == BusState::gone; }));
  EXPECT_TRUE(mentions(bus.trouble(), "plug it in")) << bus.trouble();
  EXPECT_EQ(bus.try_send({.id = 1}), SendResult::down);
  bus.close();
  EXPECT_FALSE(bus.open());
  EXPECT_TRUE(mentions(bus.trouble(), "no interface vcantest")) << bus.trouble();
  create();
  EXPECT_EQ(bus.state(), BusState::closed);
  ASSERT_TRUE(bus.open()) << bus.trouble();
  EXPECT_EQ(bus.try_send({.id = 1}), SendResult::queued);
  EXPECT_TRUE(becomes_true(bus, [&] { return bus.counters().sent == 1; }));
}

TEST_F(VirtualCanTest, AnInterfaceThatIsDownIsNotOpened) {
  set("down");
  EXPECT_FALSE(bus.open());
  EXPECT_TRUE(mentions(bus.trouble(), "vcantest is down: ip link set vcantest up")) << bus.trouble();
}

TEST_F(VirtualCanTest, AClassicInterfaceIsNotTakenForCanFd) {
  set("down");
  set("mtu 16 up");
  SocketCanBus fd_bus(name, {.bit_rate = 1e6, .data_bit_rate = 5e6});
  EXPECT_FALSE(fd_bus.open());
  EXPECT_TRUE(mentions(fd_bus.trouble(), "mtu 72")) << fd_bus.trouble();
  ASSERT_TRUE(bus.open());
  EXPECT_EQ(bus.try_send({.id = 1, .fd = true, .size = 64}), SendResult::invalid);
}

TEST_F(VirtualCanTest, OtherInterfacesAreNotCan) {
  SocketCanBus loopback("lo", {});
  EXPECT_FALSE(loopback.open());
  EXPECT_TRUE(mentions(loopback.trouble(), "no CAN interface")) << loopback.trouble();
}

TEST_F(VirtualCanTest, AQueueThatDropsSilentlyIsNamed) {
  ASSERT_TRUE(bus.open());
  EXPECT_EQ(bus.trouble(), "");
  limit("fq_codel");
  EXPECT_TRUE(mentions(bus.trouble(), "pfifo_fast")) << bus.trouble();
}

}  // namespace
}  // namespace godobject::test::test_interface
