// Frames there and back, their time stamps, filters and the confirmation of own frames.
#include <gmock/gmock.h>

#include <fstream>
#include <sstream>

#include "hal/can/candump.h"
#include "tests/socketcan/can_test.h"
#include "tests/support/allocation_guard.h"

namespace godobject::test::test_round_trip {
namespace {

CanFrame frame_of(std::uint32_t id, std::uint8_t size, bool fd = false) {
  CanFrame frame{.id = id, .extended = id > 0x7FF, .fd = fd, .size = size};
  for (std::uint8_t i = 0; i < size; ++i) frame.data[i] = static_cast<std::uint8_t>(id + 3u * i);
  return frame;
}

std::vector<CanFrame> frames_of_all_kinds(bool with_fd) {
  std::vector<CanFrame> frames{frame_of(0, 0), frame_of(0x7FF, 8), frame_of(0x1FFF'FFFF, 8),
                               frame_of(0x800, 1)};
  CanFrame remote{.id = 0x123, .remote = true, .size = 4};
  frames.push_back(remote);
  if (!with_fd) return frames;
  for (const std::uint8_t size : {std::uint8_t{0}, std::uint8_t{8}, std::uint8_t{12}, std::uint8_t{64}}) {
    frames.push_back(frame_of(0x100u + size, size, true));
    frames.back().bit_rate_switch = size > 8;
  }
  frames.push_back(frame_of(0x1234'5678, 64, true));
  return frames;
}

void expect_same(const CanFrame& a, const CanFrame& b) {
  EXPECT_EQ(a.id, b.id);
  EXPECT_EQ(a.extended, b.extended);
  EXPECT_EQ(a.remote, b.remote);
  EXPECT_EQ(a.fd, b.fd);
  EXPECT_EQ(a.bit_rate_switch, b.bit_rate_switch);
  ASSERT_EQ(a.size, b.size);
  EXPECT_TRUE(std::equal(a.bytes().begin(), a.bytes().end(), b.bytes().begin()));
}

TEST_F(CanPairTest, EveryKindOfFrameArrivesAsItWasSent) {
  for (const CanFrame& frame : frames_of_all_kinds(carries_fd)) {
    ASSERT_EQ(near->try_send(frame), SendResult::queued);
    const auto received = receive(*far);
    ASSERT_TRUE(received) << std::hex << frame.id;
    expect_same(received->frame, frame);
  }
  EXPECT_EQ(near->state(), BusState::error_active);
}

TEST_F(CanPairTest, FdFramesAreRefusedWhereTheInterfaceIsClassic) {
  if (carries_fd) GTEST_SKIP() << near_name << " carries CAN FD";
  EXPECT_EQ(near->try_send(frame_of(0x100, 8, true)), SendResult::invalid);
}

TEST_F(CanPairTest, OwnFramesAreConfirmedAndNotReturned) {
  constexpr int frames = 8;  // fewer than a transmit queue holds by default
  for (std::uint32_t i = 0; i < frames; ++i)

    ASSERT_EQ(near->try_send(frame_of(0x200 + i, 4)), SendResult::queued);
  EXPECT_EQ(drain(*far), std::size_t{frames});
  EXPECT_TRUE(becomes_true(*near, [&] { return near->counters().sent == frames; })) << near->counters().sent;
  EXPECT_EQ(near->counters().received, 0u);
  EXPECT_EQ(far->counters().sent, 0u);
  EXPECT_EQ(far->counters().received, std::uint64_t{frames});
}

TEST_F(CanPairTest, TimeStampsAreOnTheMonotonicClockAndInOrder) {
  Nanoseconds last = 0;
  for (std::uint32_t i = 0; i < 50; ++i) {
    const Nanoseconds before = MonotonicClock{}.now();
    ASSERT_EQ(near->try_send(frame_of(0x300 + i, 8)), SendResult::queued);
    if (i % 10 == 0) pause_ms(20);  // a waiting frame keeps its time of arrival
    const Nanoseconds sent = MonotonicClock{}.now();
    const auto received = receive(*far);
    ASSERT_TRUE(received);
    const Nanoseconds after = MonotonicClock{}.now();
    // receive() reads both clocks, at instants that lie apart by the time of its call at most.
    const Nanoseconds error = 50'000 + (after - sent) / 2;
    EXPECT_GE(received->t_ns, std::max(before - error, last));
    EXPECT_LE(received->t_ns, after);
    if (i % 10 == 0) {
      EXPECT_LT(received->t_ns, sent - 5'000'000 + error);
    }
    last = received->t_ns;
  }
}

TEST_F(CanPairTest, TimeStampsSurviveASetWallClock) {
  ASSERT_EQ(near->try_send(frame_of(0x300, 8)), SendResult::queued);
  pause_ms(20);
  run("date -s '+1 hour' > /dev/null");
  const auto received = receive(*far);
  const Nanoseconds after = MonotonicClock{}.now();
  run("date -s '-1 hour' > /dev/null");
  ASSERT_TRUE(received);
  EXPECT_LE(received->t_ns, after);
  EXPECT_GT(received->t_ns, after - 2'000'000'000);
}

TEST_F(CanPairTest, OnlyWantedIdentifiersPass) {
  const CanFilter wanted[] = {{.id = 0x181, .mask = 0x7FF},
                              {.id = 0x12345, .mask = 0x1FFF'FFFF, .extended = true}};
  SocketCanBus filtered(far_name, {.bit_rate = bit_rate, .filters = wanted});
  ASSERT_TRUE(filtered.open()) << filtered.trouble();
  const CanFrame frames[] = {frame_of(0x180, 1),
                             frame_of(0x181, 2),
                             frame_of(0x12345, 3),
                             frame_of(0x12346, 4),
                             {.id = 0x181, .extended = true, .size = 5},
                             {.id = 0x181, .remote = true}};
  for (const CanFrame& frame : frames) ASSERT_EQ(near->try_send(frame), SendResult::queued);
  std::vector<int> sizes;
  while (const auto received = receive(filtered, 300)) sizes.push_back(received->frame.size);
  EXPECT_THAT(sizes, testing::ElementsAre(2, 3));
}

// Filters act on own frames too: those that pass are confirmed, others are sent nevertheless.
TEST_F(CanPairTest, OwnFramesAreConfirmedWhereTheyPassTheFilter) {
  const CanFilter wanted[] = {{.id = 0x201, .mask = 0x7FF}};
  SocketCanBus filtered(near_name, {.bit_rate = bit_rate, .filters = wanted});
  ASSERT_TRUE(filtered.open());
  ASSERT_EQ(filtered.try_send(frame_of(0x201, 1)), SendResult::queued);
  ASSERT_EQ(filtered.try_send(frame_of(0x202, 1)), SendResult::queued);
  EXPECT_EQ(drain(*far), 2u);
  drain(filtered);
  EXPECT_EQ(filtered.counters().sent, 1u);
}

TEST_F(CanPairTest, SendingAndReceivingNeitherAllocateNorLockNorSleep) {
  if (!AllocationGuard::works()) GTEST_SKIP() << "a sanitizer has the heap";
  std::string calls;
  std::size_t received = 0;
  {
    AllocationGuard guard;
    ReceivedFrame out;
    for (std::uint32_t i = 0; i < 5000; ++i) {
      if (i % 100 == 0) static_cast<void>(near->try_send({.id = i / 100, .size = 8}));
      if (far->try_receive(out)) ++received;
      static_cast<void>(near->try_receive(out));
    }
    calls = guard.report();
  }
  EXPECT_GT(received, 0u);
  EXPECT_THAT(calls, testing::Not(testing::ContainsRegex("alloc|free|mutex|sleep|read|write"))) << calls;
}

/// Returns the number of sockets that receive every frame of an interface.
std::size_t receivers_of_all(const std::string& interface) {
  std::ifstream list("/proc/net/can/rcvlist_all");
  std::size_t count = 0;
  for (std::string line; std::getline(list, line);)
    if (std::istringstream(line) >> line && line == interface) ++count;
  return count;
}

TEST_F(CanPairTest, CandumpSeesTheSameFrames) {
  const std::string log = testing::TempDir() + "candump.log";
  const auto frames = frames_of_all_kinds(carries_fd);
  const std::string count = std::to_string(frames.size());
  const std::size_t receivers = receivers_of_all(far_name);
  run("candump -L -n " + count + " -T 10000 " + far_name + " > " + log + " & echo");
  for (int waited_ms = 0; receivers_of_all(far_name) <= receivers && waited_ms < 30'000; waited_ms += 10)
    pause_ms(10);
  std::vector<CanFrame> received;
  for (const CanFrame& frame : frames) {
    ASSERT_EQ(near->try_send(frame), SendResult::queued);
    const auto arrived = receive(*far);
    ASSERT_TRUE(arrived);
    received.push_back(arrived->frame);
  }
  std::string lines;
  for (int i = 0; i < 500 && std::count(lines.begin(), lines.end(), '\n') != std::ssize(frames); ++i) {
    pause_ms(20);
    std::ostringstream text;
    text << std::ifstream(log).rdbuf();
    lines = text.str();
  }
  std::istringstream in(lines);
  std::string line;
  std::size_t i = 0;
  for (; std::getline(in, line); ++i) {
    ASSERT_LT(i, received.size());
    ReceivedFrame parsed;
    std::string_view interface;
    ASSERT_EQ(parse_candump(line, parsed, interface), CandumpResult::ok) << line;
    expect_same(parsed.frame, received[i]);
  }
  EXPECT_EQ(i, frames.size());
}

}  // namespace
}  // namespace godobject::test::test_round_trip
