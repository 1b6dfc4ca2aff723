// Full queues and lost frames: each loss must be reported.
#include <cinttypes>
#include <cstring>
#include <fstream>

#include "tests/socketcan/can_test.h"

namespace godobject::test::test_queues {
namespace {

// Sends frames and reads, because own frames come back through the receive queue.
std::size_t send_many(SocketCanBus& bus, std::size_t frames) {
  std::size_t queued = 0;
  ReceivedFrame ignored;
  for (std::uint32_t i = 0; i < frames; ++i) {
    if (bus.try_send({.id = i % 0x800, .size = 8}) == SendResult::queued) ++queued;
    EXPECT_FALSE(bus.try_receive(ignored));
  }
  return queued;
}

TEST_F(VirtualCanTest, EveryFrameLostToAFullReceiveQueueIsCounted) {
  constexpr std::size_t frames = 5000;
  ASSERT_TRUE(bus.open());
  ASSERT_TRUE(other.open());
  ASSERT_EQ(send_many(other, frames), frames);
  const std::size_t read = drain(bus);
  EXPECT_LT(read, frames);
  ASSERT_EQ(send_many(other, 1), 1u);  // the loss is reported with the next frame
  EXPECT_EQ(drain(bus), 1u);
  EXPECT_EQ(bus.counters().receive_overflow, frames - read);
  EXPECT_EQ(bus.counters().received, read + 1);
}

// A bus of 512 kbit/s behind a queue of a few frames.
TEST_F(VirtualCanTest, AFullTransmitQueueRefusesAndEmptiesAgain) {
  limit("tbf rate 512kbit burst 160 limit 320");
  ASSERT_TRUE(bus.open());
  ASSERT_TRUE(other.open());
  std::uint64_t queued = 0, full = 0;
  for (std::uint32_t i = 0; i < 200; ++i) {
    const SendResult result = bus.try_send({.id = i, .size = 8});
    ASSERT_TRUE(result == SendResult::queued || result == SendResult::full);
    ++(result == SendResult::queued ? queued : full);
  }
  EXPECT_GT(full, 0u);
  EXPECT_EQ(bus.counters().send_refused, full);
  EXPECT_NE(bus.trouble().find("txqueuelen"), std::string::npos) << bus.trouble();
  EXPECT_EQ(drain(other), queued);  // refused frames are not sent
  EXPECT_EQ(bus.try_send({.id = 0x300}), SendResult::queued);
  EXPECT_TRUE(becomes_true(bus, [&] { return bus.counters().sent == queued + 1; }));
}

TEST_F(VirtualCanTest, FramesLostBehindTheSocketShowAsNotConfirmed) {
  limit("netem loss 30%");
  ASSERT_TRUE(bus.open());
  ASSERT_TRUE(other.open());
  ASSERT_EQ(send_many(bus, 300), 300u);
  const std::size_t arrived = drain(other);
  drain(bus);
  EXPECT_LT(arrived, 280u);
  EXPECT_GT(arrived, 120u);
  EXPECT_EQ(bus.counters().sent, arrived);
}

TEST_F(VirtualCanTest, DelayOnTheWayShowsInTheTimeStamp) {
  limit("netem delay 30ms");
  ASSERT_TRUE(bus.open());
  ASSERT_TRUE(other.open());
  const Nanoseconds sent = MonotonicClock{}.now();
  ASSERT_EQ(bus.try_send({.id = 1}), SendResult::queued);
  const auto received = receive(other);
  ASSERT_TRUE(received);
  EXPECT_GE(received->t_ns - sent, 29'000'000);
}

/// Sequence numbers that cangen writes into its frames.
struct Sequence {
  std::uint64_t frames = 0, out_of_order = 0;
  std::optional<std::uint64_t> last;

  void see(const CanFrame& frame) {
    std::uint64_t number = 0;
    std::memcpy(&number, frame.data.data(), sizeof number);
    if (last && number <= *last) ++out_of_order;
    last = number;
    ++frames;
  }
};

std::string seconds_of_load() {
  const char* const text = std::getenv("GODOBJECT_CAN_LOAD_S");
  return text != nullptr ? text : "3";
}

std::uint64_t frames_of_interface(const std::string& name) {
  std::uint64_t frames = 0;
  std::ifstream("/sys/class/net/" + name + "/statistics/rx_packets") >> frames;
  return frames;
}

// cangen sends as fast as possible, and takes processor time from the receiver.
TEST_F(CanPairTest, NoFrameIsLostOrReorderedUnreportedAtFullLoad) {
  const std::uint64_t before = frames_of_interface(far_name);
  FILE* const cangen = popen(
      ("timeout " + seconds_of_load() + " cangen " + near_name + " -g 0 -p 10 -I 123 -L 8 -D i").c_str(),
      "r");
  Sequence sequence;
  if (const auto first = receive(*far, 30'000)) sequence.see(first->frame);  // cangen has started
  const Nanoseconds start = MonotonicClock{}.now();
  while (const auto received = receive(*far, 1000)) sequence.see(received->frame);
  const double elapsed = 1e-9 * static_cast<double>(MonotonicClock{}.now() - start) - 1;
  pclose(cangen);
  // The last loss is reported with the next frame.
  ASSERT_EQ(near->try_send({.id = 0x7FF, .size = 8}), SendResult::queued);
  ASSERT_TRUE(receive(*far));

  const BusCounters counters = far->counters();
  const std::uint64_t on_the_bus = frames_of_interface(far_name) - before - 1;
  std::printf("%" PRIu64 " frames in %.2f s on the bus: %.0f/s; received %.0f/s, %" PRIu64
              " reported as lost\n",
              on_the_bus, elapsed, static_cast<double>(on_the_bus) / elapsed,
              static_cast<double>(sequence.frames) / elapsed, counters.receive_overflow);
  EXPECT_GT(sequence.frames, 1000u);
  EXPECT_EQ(sequence.out_of_order, 0u);
  EXPECT_EQ(sequence.frames + counters.receive_overflow, on_the_bus);
}

}  // namespace
}  // namespace godobject::test::test_queues
