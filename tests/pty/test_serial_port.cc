// A serial port on a pseudo-terminal: raw bytes, full buffers, hang-up, and the errors of open().
#include <gmock/gmock.h>

#include <sys/socket.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <numeric>

#include "platform/linux/serial_port.h"
#include "tests/support/program.h"
#include "tests/support/pseudo_terminal.h"

namespace godobject::test::test_serial_port {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

constexpr Nanoseconds second = 1'000'000'000;

std::vector<std::uint8_t> every_byte() {
  std::vector<std::uint8_t> bytes(256);
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
  return bytes;
}

std::vector<std::uint8_t> read_all(SerialPort& port, std::size_t size) {
  std::vector<std::uint8_t> bytes;
  std::array<std::uint8_t, 64> buffer{};
  while (bytes.size() < size && port.state() == SerialState::open && port.wait_readable(second)) {
    const std::size_t n = port.read(buffer);
    bytes.insert(bytes.end(), buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(n));
  }
  return bytes;
}

TEST(SerialPort, EveryByteGoesThroughUnchangedBothWays) {
  PseudoTerminal device;
  SerialPort port;
  ASSERT_TRUE(port.open(device.slave(), {})) << port.trouble();
  EXPECT_THAT(port.trouble(), IsEmpty());
  EXPECT_GE(port.descriptor(), 0);
  const std::vector<std::uint8_t> sent = every_byte();
  ASSERT_EQ(port.write(sent), sent.size());
  EXPECT_EQ(device.receive(256), std::string(sent.begin(), sent.end()));
  ASSERT_TRUE(device.send(std::string(sent.begin(), sent.end())));
  EXPECT_EQ(read_all(port, 256), sent);
}

TEST(SerialPort, NothingToReadIsNotAnError) {
  PseudoTerminal device;
  SerialPort port;
  ASSERT_TRUE(port.open(device.slave(), {}));
  std::array<std::uint8_t, 8> buffer{};
  EXPECT_EQ(port.read(buffer), 0u);
  EXPECT_FALSE(port.wait_readable(0));
  EXPECT_EQ(port.state(), SerialState::open);
}

/// A kernel that delays a call: here a socket that waits for bytes, which a terminal never does.
TEST(SerialPort, CallsThatTheKernelKeepsAreCountedAndExplained) {
  std::array<int, 2> ends{};
  ASSERT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()), 0);
  const timeval patience{.tv_sec = 0, .tv_usec = 6000};
  ASSERT_EQ(setsockopt(ends[0], SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience), 0);
  SerialPort port;
  port.adopt(ends[0], "terminal");
  EXPECT_THAT(port.slowness(), IsEmpty());
  std::array<std::uint8_t, 8> buffer{};
  for (int i = 0; i < 3; ++i) EXPECT_EQ(port.read(buffer), 0u);
  EXPECT_EQ(port.state(), SerialState::open);
  EXPECT_EQ(port.slow_calls().count, 3u);
  EXPECT_GE(port.slow_calls().longest, 6'000'000 - 100'000);
  EXPECT_THAT(port.slowness(), testing::StartsWith("terminal: 3 reads or writes"));
  for (const char* remedy : {"PREEMPT_RT", "socketcan:"}) EXPECT_THAT(port.slowness(), HasSubstr(remedy));
  ::close(ends[1]);
}

TEST(SerialPort, DiscardedInputIsNotRead) {
  PseudoTerminal device;
  SerialPort port;
  ASSERT_TRUE(port.open(device.slave(), {}));
  ASSERT_TRUE(device.send("old"));
  ASSERT_TRUE(port.wait_readable(second));
  port.discard_input();
  ASSERT_TRUE(device.send("new"));
  const std::vector<std::uint8_t> bytes = read_all(port, 3);
  EXPECT_EQ(std::string(bytes.begin(), bytes.end()), "new");
}

TEST(SerialPort, AFullBufferTakesLessAndStaysOpen) {
  PseudoTerminal device;
  SerialPort port;
  ASSERT_TRUE(port.open(device.slave(), {}));
  const std::vector<std::uint8_t> block(4096, 0x55);
  std::size_t taken = 0, total = 0;
  do {
    taken = port.write(block);
    total += taken;
  } while (taken > 0 && total < 1'000'000);
  EXPECT_EQ(taken, 0u);
  EXPECT_GT(total, 0u);
  EXPECT_EQ(port.state(), SerialState::open);
}

TEST(SerialPort, ReadingSeesTheHangUp) {
  PseudoTerminal device;
  SerialPort port;
  ASSERT_TRUE(port.open(device.slave(), {}));
  device.hang_up();
  ASSERT_TRUE(port.wait_readable(second));
  std::array<std::uint8_t, 8> buffer{};
  EXPECT_EQ(port.read(buffer), 0u);
  EXPECT_EQ(port.state(), SerialState::hung_up);
  EXPECT_THAT(port.trouble(), HasSubstr(device.slave()));
  EXPECT_THAT(port.trouble(), HasSubstr("reopen"));
  EXPECT_EQ(port.write(buffer), 0u);
  port.close();
  EXPECT_EQ(port.state(), SerialState::closed);
  EXPECT_EQ(port.descriptor(), -1);
}

TEST(SerialPort, WritingSeesTheHangUp) {
  PseudoTerminal device;
  SerialPort port;
  ASSERT_TRUE(port.open(device.slave(), {}));
  device.hang_up();
  EXPECT_EQ(port.write(every_byte()), 0u);
  EXPECT_EQ(port.state(), SerialState::hung_up);
}

TEST(SerialPort, APseudoTerminalHasNoLatencyToSetAndSaysSo) {
  PseudoTerminal device;
  SerialPort port;
  ASSERT_TRUE(port.open(device.slave(), {}));
  EXPECT_EQ(port.low_latency(), LowLatency::not_a_uart);
  EXPECT_THAT(port.latency_report(), HasSubstr("not a UART"));
  ASSERT_TRUE(port.open(device.slave(), {.low_latency = false}));
  EXPECT_EQ(port.low_latency(), LowLatency::not_requested);
}

TEST(SerialPort, AnyBaudRateIsTaken) {
  PseudoTerminal device;
  SerialPort port;
  for (const std::uint32_t baud : {9600u, 14'400u, 921'600u, 1'228'739u, 12'345u}) {
    EXPECT_TRUE(port.open(device.slave(), {.baud = baud})) << port.trouble();
    EXPECT_TRUE(port.set_baud(baud + 1)) << port.trouble();
  }
  EXPECT_FALSE(port.open(device.slave(), {.baud = 0}));
  EXPECT_THAT(port.trouble(), HasSubstr("baud"));
  EXPECT_EQ(port.state(), SerialState::failed);
}

TEST(SerialPort, ASecondUserIsRefusedBecauseItIsInUse) {
  PseudoTerminal device;
  SerialPort first, second_user;
  ASSERT_TRUE(first.open(device.slave(), {}));
  EXPECT_FALSE(second_user.open(device.slave(), {}));
  EXPECT_THAT(second_user.trouble(), HasSubstr("in use"));
  first.close();
  EXPECT_TRUE(second_user.open(device.slave(), {})) << second_user.trouble();
}

TEST(SerialPort, WhatIsNotASerialPortIsRefused) {
  SerialPort port;
  EXPECT_FALSE(port.open("/dev/ttyNone", {}));
  EXPECT_THAT(port.trouble(), HasSubstr("/dev/ttyNone"));
  EXPECT_THAT(port.trouble(), HasSubstr("plugged in"));
  EXPECT_FALSE(port.open("/dev/null", {}));
  EXPECT_THAT(port.trouble(), HasSubstr("not a terminal"));
  EXPECT_FALSE(port.wait_readable(0));
}

class LatencyTimer : public ProgramTest {};

TEST_F(LatencyTimer, IsReadWhereTheDriverHasOne) {
  std::filesystem::create_directories(path("class/tty/ttyUSB7/device"));
  write("class/tty/ttyUSB7/device/latency_timer", "16\n");
  write("ttyUSB7", "");
  write("ttyACM0", "");
  std::filesystem::create_symlink(path("ttyUSB7"), path("usb-FTDI-by-id"));
  EXPECT_EQ(read_latency_timer_ms(path("ttyUSB7"), path("")), 16);
  EXPECT_EQ(read_latency_timer_ms(path("usb-FTDI-by-id"), path("")), 16);
  EXPECT_EQ(read_latency_timer_ms(path("ttyACM0"), path("")), std::nullopt);
  EXPECT_EQ(read_latency_timer_ms(path("gone"), path("")), std::nullopt);
}

}  // namespace
}  // namespace godobject::test::test_serial_port
