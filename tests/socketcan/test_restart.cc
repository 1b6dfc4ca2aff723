// Bus-off and restart with a driver that supports it: by the kernel's timer, and by hand.
#include "tests/socketcan/usb_can_adapter.h"

namespace godobject::test::test_restart {
namespace {

class RestartTest : public CanTest {
 protected:
  void SetUp() override {
    CanTest::SetUp();
    if (IsSkipped()) return;
    if (!UsbCanAdapter::possible())
      GTEST_SKIP() << "this kernel has no USB gadgets: ./dev test-can-controller brings one that has";
    adapter_.emplace();
    name_ = adapter_->interface();
    ASSERT_FALSE(name_.empty()) << "esd_usb did not take the adapter";
  }
  void TearDown() override {
    if (!name_.empty()) run("ip link set " + name_ + " down");
  }

  void open(int restart_ms) {
    run("ip link set " + name_ + " up type can bitrate 500000 restart-ms " + std::to_string(restart_ms));
    bus_ = std::make_unique<SocketCanBus>(name_, BusSettings{.bit_rate = 500e3});
    ASSERT_TRUE(bus_->open()) << bus_->trouble();
    EXPECT_EQ(bus_->try_send({.id = 1}), SendResult::queued);
    EXPECT_TRUE(becomes_true(*bus_, [&] { return bus_->counters().sent == 1; }));
  }
  bool reaches(BusState state) {
    return becomes_true(*bus_, [&] { return bus_->state() == state; });
  }
  void expect_in_use_again() {
    ASSERT_TRUE(reaches(BusState::error_active)) << bus_->trouble();
    EXPECT_EQ(bus_->counters().bus_off_events, 1u);
    EXPECT_EQ(bus_->counters().restarts, 1u);
    EXPECT_EQ(bus_->counters().last_error, BusError::restarted);
    EXPECT_EQ(bus_->try_send({.id = 2}), SendResult::queued);
    EXPECT_TRUE(becomes_true(*bus_, [&] { return bus_->counters().sent == 2; }));
  }

  std::optional<UsbCanAdapter> adapter_;
  std::string name_;
  std::unique_ptr<SocketCanBus> bus_;
};

TEST_F(RestartTest, ByHandAsTheTroubleSays) {
  open(0);
  adapter_->report(UsbCanAdapter::State::bus_off);
  ASSERT_TRUE(reaches(BusState::bus_off));
  EXPECT_EQ(bus_->try_send({.id = 2}), SendResult::off);
  const std::string command = "ip link set " + name_ + " type can restart";
  EXPECT_NE(bus_->trouble().find(command), std::string::npos) << bus_->trouble();
  pause_ms(50);
  EXPECT_FALSE(becomes_true(
      *bus_, [&] { return bus_->state() != BusState::bus_off; }, 50));
  run(command);
  expect_in_use_again();
}

TEST_F(RestartTest, ByTheKernelAfterRestartMs) {
  open(1000);
  adapter_->report(UsbCanAdapter::State::bus_off);
  ASSERT_TRUE(reaches(BusState::bus_off));
  EXPECT_NE(bus_->trouble().find("1000 ms after each bus-off"), std::string::npos) << bus_->trouble();
  expect_in_use_again();
}

}  // namespace
}  // namespace godobject::test::test_restart
