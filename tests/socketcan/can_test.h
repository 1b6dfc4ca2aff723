// Shared parts of the tests on a real CAN stack. They change interfaces, so they run only if
// tests/vm/can_interfaces has set up interfaces for them, and are skipped elsewhere.
// An emulated guest may be held up by its host, so each wait is for an event and has a long limit.
#pragma once

#include <gtest/gtest.h>
#include <linux/can/raw.h>
#include <poll.h>
#include <unistd.h>

#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "platform/linux/bus/socket_can.h"
#include "platform/rt/cyclic.h"

namespace godobject::test {

/// Returns the output of a shell command that must succeed.
inline std::string run(const std::string& command) {
  FILE* const pipe = popen((command + " 2>&1").c_str(), "r");
  std::string output;
  char buffer[4096];
  while (const std::size_t size = fread(buffer, 1, sizeof buffer, pipe)) output.append(buffer, size);
  const int status = pclose(pipe);
  EXPECT_EQ(status, 0) << command << "\n" << output;
  return output;
}

inline void pause_ms(int ms) { poll(nullptr, 0, ms); }

/// Returns the next frame, or none after the timeout.
inline std::optional<ReceivedFrame> receive(LinuxBus& bus, int timeout_ms = 10'000) {
  ReceivedFrame out;
  if (bus.try_receive(out)) return out;
  const Nanoseconds end = MonotonicClock{}.now() + Nanoseconds{timeout_ms} * 1'000'000;
  while (!bus.try_receive(out)) {
    const Nanoseconds left = end - MonotonicClock{}.now();
    if (left <= 0 || bus.descriptor() < 0) return std::nullopt;
    pollfd waiting{.fd = bus.descriptor(), .events = POLLIN, .revents = 0};
    poll(&waiting, 1, static_cast<int>(left / 1'000'000) + 1);
  }
  return out;
}

/// Reads until no frame has come for this time; returns the number of frames.
inline std::size_t drain(LinuxBus& bus, int quiet_ms = 300) {
  std::size_t frames = 0;
  while (receive(bus, quiet_ms)) ++frames;
  return frames;
}

/// Returns true once `holds`, evaluated between reads of the bus; false after the timeout.
template <class Condition>
bool becomes_true(LinuxBus& bus, Condition&& holds, int timeout_ms = 10'000) {
  for (int waited = 0; waited < timeout_ms; waited += 5) {
    ReceivedFrame ignored;
    while (bus.try_receive(ignored)) continue;
    if (holds()) return true;
    pause_ms(5);
  }
  return holds();
}

inline bool has_can() {
  const int fd = socket(PF_CAN, SOCK_RAW, CAN_RAW);
  if (fd >= 0) ::close(fd);
  return fd >= 0;
}

/// Returns why no interfaces are set up for tests; empty if they are.
inline std::string why_no_interfaces() {
  if (std::getenv("GODOBJECT_CAN_NEAR") != nullptr) return "";
  return std::string(has_can() ? "" : "this kernel has no AF_CAN; ") +
         "ctest -R guest.SocketCan runs this in a guest kernel";
}

class CanTest : public testing::Test {
 protected:
  void SetUp() override {
    if (const std::string reason = why_no_interfaces(); !reason.empty()) GTEST_SKIP() << reason;
    ASSERT_TRUE(has_can()) << "no AF_CAN here";
  }
};

/// Two interfaces on one bus (or the same one twice), for tests that run on vcan and on controllers.
class CanPairTest : public CanTest {
 protected:
  void SetUp() override {
    CanTest::SetUp();
    if (IsSkipped()) return;
    near_name = std::getenv("GODOBJECT_CAN_NEAR");
    far_name = std::getenv("GODOBJECT_CAN_FAR");
    CanLink link;
    ASSERT_EQ(read_can_link(near_name.c_str(), link), 0);
    carries_fd = link.carries_fd();
    if (link.controller) bit_rate = link.controller->bit_rate;
    near = std::make_unique<SocketCanBus>(near_name, BusSettings{.bit_rate = bit_rate});
    far = std::make_unique<SocketCanBus>(far_name, BusSettings{.bit_rate = bit_rate});
    ASSERT_TRUE(near->open()) << near->trouble();
    ASSERT_TRUE(far->open()) << far->trouble();
  }

  std::string near_name, far_name;
  bool carries_fd = false;
  double bit_rate = 1e6;
  std::unique_ptr<SocketCanBus> near, far;
};

/// A virtual interface of this test's own.
class VirtualCanTest : public CanTest {
 protected:
  static constexpr const char* name = "vcantest";

  void SetUp() override {
    CanTest::SetUp();
    if (!IsSkipped()) create();
  }
  void TearDown() override {
    if (!IsSkipped() && if_nametoindex(name) != 0) remove();
  }

  static void create() {
    run(std::string("ip link add dev ") + name + " type vcan && ip link set " + name + " mtu 72 up");
  }
  static void remove() { run(std::string("ip link delete ") + name); }
  static void set(const std::string& what) { run(std::string("ip link set ") + name + " " + what); }
  static void limit(const std::string& discipline) {
    run(std::string("tc qdisc add dev ") + name + " root " + discipline);
  }

  SocketCanBus bus{name, {}};
  SocketCanBus other{name, {}};
};

}  // namespace godobject::test
