// A log as a bus: order, spacing, interfaces and filters, errors of a log, and a real recording.
#include <gmock/gmock.h>

#include <poll.h>

#include "platform/linux/bus/bus.h"
#include "platform/rt/cyclic.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/program.h"
#include "tests/support/shared_data.h"

namespace godobject::test::test_replay_bus {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

class Replay : public ProgramTest {
 protected:
  /// Waits for the next frame by the bus's descriptor; returns false at the end of the log.
  static bool receive(ReplayBus& bus, ReceivedFrame& frame) {
    while (!bus.try_receive(frame)) {
      if (is_cut_off(bus.state())) return false;
      pollfd waiting{.fd = bus.descriptor(), .events = POLLIN, .revents = 0};
      if (poll(&waiting, 1, 10'000) != 1) return false;
    }
    return true;
  }
};

TEST_F(Replay, FramesComeInOrderWithTheSpacingOfTheLog) {
  const std::string log = write("a.log",
                                "a line that is none\n"
                                "(1600000000.000000) can0 080#\n"
                                "(1600000000.000500) can0 181#01020304\n"
                                "(1600000000.000400) can0 00000181#R4\n"
                                "(1600000000.020000) can0 701##105\r\n");
  ReplayBus bus(log, {});
  const Nanoseconds before = MonotonicClock().now();
  ASSERT_TRUE(bus.open()) << bus.trouble();
  EXPECT_EQ(bus.state(), BusState::error_active);
  EXPECT_THAT(bus.trouble(), IsEmpty());
  std::vector<ReceivedFrame> frames(4);
  for (ReceivedFrame& frame : frames) ASSERT_TRUE(receive(bus, frame));
  EXPECT_GE(frames[0].t_ns, before);
  EXPECT_EQ(frames[1].t_ns - frames[0].t_ns, 500'000);
  EXPECT_EQ(frames[2].t_ns - frames[0].t_ns, 500'000) << "time does not go back";
  EXPECT_EQ(frames[3].t_ns - frames[0].t_ns, 20'000'000);
  EXPECT_GE(MonotonicClock().now(), frames[3].t_ns);
  EXPECT_EQ(frames[1].frame.size, 4);
  EXPECT_TRUE(frames[2].frame.extended && frames[2].frame.remote);
  EXPECT_TRUE(frames[3].frame.fd);
  EXPECT_EQ(bus.state(), BusState::down);
  EXPECT_THAT(bus.trouble(), HasSubstr("end of the log"));
  EXPECT_EQ(bus.counters().received, 4u);
  EXPECT_EQ(bus.try_send({.id = 0x80}), SendResult::down);
}

TEST_F(Replay, AFrameThatIsNotDueIsNotReceived) {
  ReplayBus bus(write("a.log", "(0.000000) can0 080#\n(1000.000000) can0 081#\n"), {});
  ASSERT_TRUE(bus.open());
  ReceivedFrame frame;
  ASSERT_TRUE(bus.try_receive(frame));
  EXPECT_FALSE(bus.try_receive(frame));
  EXPECT_EQ(bus.state(), BusState::error_active);
  pollfd waiting{.fd = bus.descriptor(), .events = POLLIN, .revents = 0};
  EXPECT_EQ(poll(&waiting, 1, 0), 0);
}

TEST_F(Replay, WhatIsSentIsTakenCountedAndDropped) {
  ReplayBus bus(write("a.log", "(0.000000) can0 080#\n(9.000000) can0 081#\n"), {});
  ASSERT_TRUE(bus.open());
  EXPECT_EQ(bus.try_send({.id = 0x201, .size = 4}), SendResult::queued);
  EXPECT_EQ(bus.try_send({.id = 0x800}), SendResult::invalid);
  EXPECT_EQ(bus.counters().sent, 1u);
  EXPECT_EQ(bus.counters().send_refused, 1u);
}

TEST_F(Replay, OneInterfaceOfSeveralIsChosen) {
  const std::string log =
      write("a,b.log", "(1.000000) can0 080#\n(1.000000) can1 081#\n(1.000000) can0 20000004#00\n");
  ReplayBus both(log, {});
  EXPECT_FALSE(both.open());
  EXPECT_THAT(both.trouble(), HasSubstr("can0, can1: choose one"));
  ReplayBus other(log + ",can7", {});
  EXPECT_FALSE(other.open());
  EXPECT_THAT(other.trouble(), HasSubstr("no frame of can7, only of can0, can1"));
  ReplayBus bus(log + ",can1", {});
  ASSERT_TRUE(bus.open()) << bus.trouble();
  ReceivedFrame frame;
  ASSERT_TRUE(receive(bus, frame));
  EXPECT_EQ(frame.frame.id, 0x081u);
  EXPECT_FALSE(receive(bus, frame));
}

TEST_F(Replay, FiltersPassWhatIsWanted) {
  const std::array filters{CanFilter{.id = 0x180, .mask = 0x780}, CanFilter{.id = 0x700, .mask = 0x7FF}};
  ReplayBus bus(write("a.log",
                      "(1.000000) can0 080#\n(1.000000) can0 185#\n(1.000000) can0 00000185#\n"
                      "(1.000000) can0 700#\n(1.000000) can0 701#\n"),
                {.filters = filters});
  ASSERT_TRUE(bus.open());
  ReceivedFrame frame;
  ASSERT_TRUE(receive(bus, frame));
  EXPECT_EQ(frame.frame.id, 0x185u);
  EXPECT_FALSE(frame.frame.extended);
  ASSERT_TRUE(receive(bus, frame));
  EXPECT_EQ(frame.frame.id, 0x700u);
  EXPECT_FALSE(receive(bus, frame));
}

TEST_F(Replay, ALogThatIsWrongIsRefusedWithItsLine) {
  for (const auto& [text, expected] :
       {std::pair{"(1.000000) can0 080#\n(1.0) can0 080#\n", "line 2: the time"},
        {"(1.000000) can0 80#\n", "line 1: the identifier"},
        {"(1.000000) can0 080#123\n", "line 1: the data"},
        {"nothing\n", "holds no frame"},
        {"", "is empty"}}) {
    ReplayBus bus(write("a.log", text), {});
    EXPECT_FALSE(bus.open());
    EXPECT_THAT(bus.trouble(), HasSubstr(expected));
    EXPECT_EQ(bus.state(), BusState::closed);
  }
  ReplayBus missing(path("missing.log"), {});
  EXPECT_FALSE(missing.open());
  EXPECT_THAT(missing.trouble(), HasSubstr("No such file"));
  ReplayBus folder(path(""), {});
  EXPECT_FALSE(folder.open());
  EXPECT_THAT(folder.trouble(), HasSubstr("is a directory"));
}

/// Log of a program that was killed while writing.
TEST_F(Replay, ALastLineThatIsCutIsLeftOut) {
  const std::string whole = "(1.000000) can0 080#\n(1.000000) can0 181#0102030405060708\n";
  const std::string last = "(1.000100) can0 181#1112131415161718";
  for (std::size_t size = 0; size <= last.size() + 1; ++size) {
    ReplayBus bus(write("a.log", whole + (last + "\n").substr(0, size)), {});
    ASSERT_TRUE(bus.open()) << bus.trouble();
    ReceivedFrame frame;
    std::size_t num_frames = 0;
    for (; receive(bus, frame); ++num_frames)
      EXPECT_TRUE(frame.frame.id == 0x080 || frame.frame.size == 8) << size;
    EXPECT_EQ(num_frames, size < last.size() ? 2u : 3u) << size;
    EXPECT_EQ(bus.trouble().find("cut off") != std::string::npos, size > 0 && size < last.size())
        << bus.trouble();
  }
  ReplayBus bus(write("a.log", "(1.000000) can0 0"), {});
  EXPECT_FALSE(bus.open());
  EXPECT_THAT(bus.trouble(), HasSubstr("holds no frame"));
}

TEST_F(Replay, ErrorFramesOfTheLogAreCounted) {
  ReplayBus bus(write("a.log", "(1.000000) can0 080#\n(1.000000) can0 20000004#0004000000000000\n"), {});
  ASSERT_TRUE(bus.open());
  ReceivedFrame frame;
  ASSERT_TRUE(receive(bus, frame));
  EXPECT_FALSE(receive(bus, frame));
  EXPECT_EQ(bus.counters().error_frames, 1u);
}

TEST_F(Replay, ARecordingOfACarPlaysWithoutAllocating) {
  const std::filesystem::path recording = shared_file("data/can/vehicle/can_sample.log");
  if (recording.empty()) GTEST_SKIP() << "the recording can_sample.log is not there: see GODOBJECT_SHARED";
  ReplayBus bus(recording.string(), {});
  ASSERT_TRUE(bus.open()) << bus.trouble();
  constexpr std::size_t num_frames = 300;  // a third of a second of its 914 frames per second
  ReceivedFrame first, frame;
  ASSERT_TRUE(receive(bus, first));
  frame = first;
  AllocationGuard guard;
  for (std::size_t i = 1; i < num_frames; ++i) {
    const Nanoseconds last = frame.t_ns;
    ASSERT_TRUE(receive(bus, frame));
    ASSERT_GE(frame.t_ns, last);
  }
  guard.disarm();
  EXPECT_EQ(guard.heap_calls(), 0) << guard.report();
  const double rate = (num_frames - 1) / (1e-9 * static_cast<double>(frame.t_ns - first.t_ns));
  EXPECT_NEAR(rate, 914, 300) << "as recorded: a matter of the log, not of this machine";
}

}  // namespace
}  // namespace godobject::test::test_replay_bus
