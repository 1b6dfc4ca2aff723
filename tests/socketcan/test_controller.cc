// States and errors of a controller, as reported by the kernel's slcan driver. The error frames are real and
// come from a real driver; the test is the adapter at the other end of a pseudo-terminal.
// Reports (Lawicel, linux drivers/net/can/slcan): "s" a|w|p|b RRR TTT state with REC and TEC; "e" N codes.
#include <fcntl.h>
#include <linux/can/error.h>
#include <linux/sockios.h>
#include <linux/tty.h>
#include <sys/ioctl.h>
#include <termios.h>

#include <array>
#include <cstring>
#include <mutex>
#include <thread>

#include "tests/socketcan/can_test.h"

namespace godobject::test::test_controller {
namespace {

constexpr double bit_rate_of_the_interface = 500e3;

class ControllerTest : public CanTest {
 protected:
  void SetUp() override {
    CanTest::SetUp();
    if (IsSkipped()) return;
    adapter_ = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK);
    ASSERT_EQ(grantpt(adapter_) + unlockpt(adapter_), 0);
    line_ = ::open(ptsname(adapter_), O_RDWR | O_NOCTTY);
    termios raw{};
    tcgetattr(line_, &raw);
    cfmakeraw(&raw);
    tcsetattr(line_, TCSANOW, &raw);
    const int discipline = N_SLCAN;
    ASSERT_EQ(ioctl(line_, TIOCSETD, &discipline), 0) << std::strerror(errno) << ": modprobe slcan";
    std::array<char, IFNAMSIZ> assigned{};
    ASSERT_EQ(ioctl(line_, SIOCGIFNAME, assigned.data()), 0);
    name = assigned.data();
    reader_ = std::jthread([this](const std::stop_token& stop) { read_line(stop); });
    run("ip link set " + name + " type can bitrate 500000 && ip link set " + name + " up");
    bus = std::make_unique<SocketCanBus>(name, BusSettings{.bit_rate = bit_rate_of_the_interface});
    ASSERT_TRUE(bus->open()) << bus->trouble();
  }

  void TearDown() override {
    // While the driver's messages to its adapter are still read.
    if (line_ >= 0 && !name.empty()) run("ip link set " + name + " down");
    unplug();
  }

  void unplug() {
    reader_ = {};
    if (line_ >= 0) close(line_);
    if (adapter_ >= 0) close(adapter_);
    line_ = adapter_ = -1;
  }

  void report(std::string_view text) const {
    ASSERT_EQ(write(adapter_, text.data(), text.size()), std::ssize(text));
  }
  bool reaches(BusState state) {
    return becomes_true(*bus, [&] { return bus->state() == state; });
  }

  std::string name;
  std::unique_ptr<SocketCanBus> bus;

  bool has_been_told(std::string_view text) {
    const std::lock_guard lock(mutex_);
    return told_.find(text) != std::string::npos;
  }

 private:
  /// Reads the driver's commands, because the driver waits for that.
  void read_line(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      pollfd waiting{.fd = adapter_, .events = POLLIN, .revents = 0};
      poll(&waiting, 1, 20);
      char text[256];
      const ssize_t size = read(adapter_, text, sizeof text);
      const std::lock_guard lock(mutex_);
      if (size > 0) told_.append(text, static_cast<std::size_t>(size));
    }
  }

  int adapter_ = -1, line_ = -1;
  std::mutex mutex_;
  std::string told_;  // bytes written by the driver
  std::jthread reader_;
};

TEST_F(ControllerTest, WarningPassiveBusOffAndBack) {
  report("sw096100\r");
  ASSERT_TRUE(reaches(BusState::error_warning));
  EXPECT_EQ(bus->counters().receive_error_counter, 96);
  EXPECT_EQ(bus->counters().transmit_error_counter, 100);
  EXPECT_NE(bus->trouble().find("TEC 100, REC 96"), std::string::npos) << bus->trouble();

  report("sp128200\r");
  ASSERT_TRUE(reaches(BusState::error_passive));
  EXPECT_EQ(bus->try_send({.id = 1}), SendResult::queued);  // a passive controller still sends

  report("sb255000\r");
  ASSERT_TRUE(reaches(BusState::bus_off));
  EXPECT_EQ(bus->counters().bus_off_events, 1u);
  EXPECT_EQ(bus->try_send({.id = 1}), SendResult::off);
  EXPECT_NE(bus->trouble().find("type can restart"), std::string::npos) << bus->trouble();

  run("ip link set " + name + " down");
  ASSERT_TRUE(reaches(BusState::down));
  EXPECT_NE(bus->trouble().find("bitrate 500000"), std::string::npos) << bus->trouble();
  run("ip link set " + name + " up");
  EXPECT_EQ(bus->try_send({.id = 1}), SendResult::queued);
  EXPECT_EQ(bus->state(), BusState::error_active);
}

TEST_F(ControllerTest, AControllerRecoversByItself) {
  report("sp128200\r");
  ASSERT_TRUE(reaches(BusState::error_passive));
  report("sw050100\r");
  ASSERT_TRUE(reaches(BusState::error_warning));
  report("sa000000\r");
  EXPECT_TRUE(reaches(BusState::error_active));
}

TEST_F(ControllerTest, AStateFromBeforeIsFoundAtOpen) {
  report("sp128200\r");
  ASSERT_TRUE(reaches(BusState::error_passive));
  SocketCanBus late(name, {.bit_rate = bit_rate_of_the_interface});
  ASSERT_TRUE(late.open());
  EXPECT_EQ(late.state(), BusState::error_passive);
}

TEST_F(ControllerTest, EachErrorHasItsName) {
  const struct {
    std::string_view report;
    BusError error;
  } lines[] = {{"e1c\r", BusError::crc},
               {"e1b\r", BusError::bit},
               {"e1s\r", BusError::stuff},
               {"e1a\r", BusError::acknowledge},
               {"e1f\r", BusError::form},
               {"e1B\r", BusError::bit},
               {"e1o\r", BusError::receive_overflow},
               {"e1O\r", BusError::transmit_overflow}};
  for (const auto& line : lines) {
    const std::uint64_t before = bus->counters().error_frames;
    report(line.report);
    ASSERT_TRUE(becomes_true(*bus, [&] { return bus->counters().error_frames == before + 1; }))
        << line.report;
    EXPECT_EQ(bus->counters().last_error, line.error) << line.report;
    EXPECT_EQ(bus->state(), BusState::error_active) << line.report;
  }
}

TEST_F(ControllerTest, FramesPassBothWays) {
  report("t12321122\r");
  const auto received = receive(*bus);
  ASSERT_TRUE(received);
  EXPECT_EQ(received->frame.id, 0x123u);
  EXPECT_EQ(received->frame.size, 2);
  ASSERT_EQ(bus->try_send({.id = 0x456, .size = 2, .data = {0xAA, 0xBB}}), SendResult::queued);
  EXPECT_TRUE(becomes_true(*bus, [&] { return has_been_told("t4562AABB"); }));
}

TEST_F(ControllerTest, AnotherBitRateThanExpectedIsRefused) {
  SocketCanBus wrong(name, {.bit_rate = 1e6});
  EXPECT_FALSE(wrong.open());
  EXPECT_NE(wrong.trouble().find("runs at 500000 bit/s, the scene has 1000000"), std::string::npos)
      << wrong.trouble();
  EXPECT_NE(wrong.trouble().find("bitrate 1000000"), std::string::npos) << wrong.trouble();
}

TEST_F(ControllerTest, ABusThatWouldStayOffIsNamed) {
  EXPECT_NE(bus->trouble().find("restart-ms 0"), std::string::npos) << bus->trouble();
}

TEST_F(ControllerTest, UnpluggingTheAdapterRemovesTheInterface) {
  unplug();
  EXPECT_TRUE(reaches(BusState::gone));
  EXPECT_EQ(bus->try_send({.id = 1}), SendResult::down);
}

// slcan has no restart, so its report is sent by another socket, as by a driver; test_restart.cc uses a real
// one.
TEST_F(VirtualCanTest, ARestartEndsBusOff) {
  ASSERT_TRUE(bus.open());
  const int driver = socket(PF_CAN, SOCK_RAW, CAN_RAW);
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(if_nametoindex(name));
  ASSERT_EQ(bind(driver, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  const auto send_error = [&](std::uint32_t error_class) {
    can_frame frame{};
    frame.can_id = CAN_ERR_FLAG | error_class;
    frame.len = CAN_ERR_DLC;
    ASSERT_EQ(write(driver, &frame, sizeof frame), ssize_t{sizeof frame});
  };
  send_error(CAN_ERR_BUSOFF);
  ASSERT_TRUE(becomes_true(bus, [&] { return bus.state() == BusState::bus_off; }));
  EXPECT_EQ(bus.try_send({.id = 1}), SendResult::off);
  send_error(CAN_ERR_RESTARTED);
  ASSERT_TRUE(becomes_true(bus, [&] { return bus.state() == BusState::error_active; }));
  EXPECT_EQ(bus.counters().restarts, 1u);
  EXPECT_EQ(bus.try_send({.id = 1}), SendResult::queued);
  close(driver);
}

}  // namespace
}  // namespace godobject::test::test_controller
