// An encoder board at the end of a serial line, and a rig that uses it as a bus of encoders.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "hal/rig/rig.h"
#include "platform/linux/bus/slcan.h"
#include "platform/linux/link.h"
#include "sim/node/encoder_board.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/pseudo_terminal.h"

namespace godobject::test::test_board_bus {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

constexpr Nanoseconds ms = 1'000'000;
constexpr double counts_per_rad = 1000;

/// Sends at 1 kHz with two channels: the first runs at 1000 counts a second, the second rests. Faults are set
/// between frames.
class Board {
 public:
  Board() : thread_([this] { run(); }) {}
  ~Board() { stop(); }
  void unplug() {
    stop();
    terminal_.hang_up();
  }
  const std::string& path() const { return terminal_.slave(); }

  std::atomic<double> drop{0}, corrupt{0};
  std::atomic<bool> silent{false};

 private:
  void stop() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }
  void run() {
    const MonotonicClock clock;
    const Nanoseconds start = clock.now();
    while (!stop_) {
      const Nanoseconds now = clock.now();
      board_.faults = {.silent = silent, .drop_probability = drop, .corrupt_probability = corrupt};
      board_.set_count(0, static_cast<std::int32_t>((now - start) / ms));
      std::array<std::uint8_t, max_encoder_wire> wire{};
      const auto bytes = board_.transmit(wire, now);
      if (!bytes.empty()) terminal_.send(std::string(bytes.begin(), bytes.end()));
      clock.sleep_until(now + ms / 2);
    }
  }

  PseudoTerminal terminal_;
  SimEncoderBoard board_{1000, 2, 1};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

constexpr double cycle_s = 2e-3;

/// Test machines are slow at times, so limits are wide.
RigParams two_encoders() {
  RigParams rig;
  rig.buses = {{.name = "arm"}};
  rig.tree.joints = {{.name = "yaw"}, {.name = "pitch", .axis_J = Vec3::UnitY()}};
  rig.tree.handles = {{.body = "tool", .joint = "pitch"}};
  for (const std::uint8_t node : {std::uint8_t{1}, std::uint8_t{2}})
    rig.encoders.push_back({.joint = rig.tree.joints[node - 1u].name,
                            .node_id = node,
                            .calibration = {.counts_per_unit = counts_per_rad},
                            .max_speed = 1000});
  rig.stale_after_s = 0.5;
  rig.boot_timeout_s = 20;
  rig.heartbeat_timeout_s = 2;
  return rig;
}

class BoardBusTest : public testing::Test {
 protected:
  void open() {
    std::vector<std::unique_ptr<LinuxBus>> buses;
    buses.push_back(std::make_unique<BoardBus>(board_->path(), BusSettings{}));
    link_ = std::make_unique<LinuxLink>(std::move(buses), to_ns(cycle_s));
    ASSERT_TRUE(link_->bus(0).open()) << link_->bus(0).trouble();
    rig_ = std::make_unique<Rig>(params_, cycle_s, link_->buses());
  }
  void cycle() {
    const Nanoseconds now = link_->begin_cycle(0);
    rig_->start(now);
    rig_->sync(now);
    Nanoseconds t{};
    do {
      t = link_->wait(now + 3 * ms / 2);
      rig_->receive(t);
    } while (!rig_->complete() && t < now + 3 * ms / 2);
    sample_ = rig_->read(t);
    static_cast<void>(rig_->command({}, t));
    link_->end_cycle();
    MonotonicClock{}.sleep_until(now + 2 * ms);
  }
  /// Runs cycles until the condition is true; returns false after 20 s.
  template <class Condition>
  bool run_until(Condition&& condition) {
    for (const Nanoseconds end = MonotonicClock{}.now() + 20'000 * ms; MonotonicClock{}.now() < end; cycle())
      if (condition()) return true;
    return condition();
  }
  bool arm() {
    return run_until([&] { return rig_->state() == RigState::ready; }) && rig_->arm();
  }
  LinuxBus& bus() { return link_->bus(0); }

  std::unique_ptr<Board> board_ = std::make_unique<Board>();
  std::unique_ptr<LinuxLink> link_;
  const RigParams params_ = two_encoders();
  std::unique_ptr<Rig> rig_;
  DeviceSample sample_;
};

TEST_F(BoardBusTest, TheRigBootsAndReadsItsJoints) {
  open();
  ASSERT_TRUE(arm()) << rig_->fault_text();
  const double before = sample_.q[0];
  const Nanoseconds start = MonotonicClock{}.now();
  AllocationGuard guard;
  for (int i = 0; i < 300; ++i) cycle();
  EXPECT_EQ(guard.heap_calls(), 0) << guard.report();
  const double s = 1e-9 * static_cast<double>(MonotonicClock{}.now() - start);
  EXPECT_NEAR(sample_.q[0] - before, s, 0.3 * s) << "1 rad/s";
  EXPECT_EQ(sample_.q[1], 0);
  EXPECT_EQ(rig_->faults(), RigFault::none) << rig_->fault_text();
  EXPECT_GT(bus().counters().received, 300u);
  EXPECT_EQ(bus().counters().error_frames, 0u);
}

TEST_F(BoardBusTest, BrokenAndLostFramesAreCountedAndNoFault) {
  open();
  ASSERT_TRUE(arm()) << rig_->fault_text();
  board_->drop = 0.1;
  board_->corrupt = 0.1;
  EXPECT_TRUE(run_until([&] {
    const BusCounters counters = bus().counters();
    return counters.error_frames > 10 && counters.receive_overflow > 20;
  }));
  EXPECT_EQ(rig_->faults(), RigFault::none) << rig_->fault_text();
  EXPECT_THAT(bus().trouble(), HasSubstr("frames were broken"));
  EXPECT_EQ(bus().counters().last_error, BusError::crc);
}

TEST_F(BoardBusTest, ASilentBoardIsStaleSamples) {
  open();
  ASSERT_TRUE(arm()) << rig_->fault_text();
  board_->silent = true;
  EXPECT_TRUE(run_until([&] { return any(rig_->faults() & RigFault::sample_stale); }));
  EXPECT_FALSE(any(rig_->faults() & RigFault::bus_down)) << "the port is there";
  EXPECT_THAT(bus().trouble(), HasSubstr("sends nothing"));
}

TEST_F(BoardBusTest, UnpluggedIsABusThatIsGone) {
  open();
  ASSERT_TRUE(arm()) << rig_->fault_text();
  board_->unplug();
  EXPECT_TRUE(run_until([&] { return any(rig_->faults() & RigFault::bus_down); }));
  EXPECT_EQ(bus().state(), BusState::gone);
  EXPECT_EQ(bus().try_send(canopen::make_sync()), SendResult::down);
  const std::uint64_t received = bus().counters().received;
  bus().close();
  EXPECT_EQ(bus().descriptor(), -1);
  board_ = std::make_unique<Board>();
  BoardBus again(board_->path(), BusSettings{});
  EXPECT_TRUE(again.open()) << again.trouble();
  EXPECT_EQ(bus().counters().received, received) << "counters outlive closing";
}

TEST_F(BoardBusTest, OtherDevicesAreReported) {
  board_->silent = true;
  open();
  cycle();
  EXPECT_EQ(bus().state(), BusState::error_active);
  EXPECT_THAT(bus().trouble(), HasSubstr("no frame of an encoder board yet"));
  BoardBus misspelt("/dev/ttyUSB0,fast", BusSettings{});
  EXPECT_FALSE(misspelt.open());
  EXPECT_THAT(misspelt.trouble(), HasSubstr("baud rate after the comma"));
  BoardBus absent("/dev/no-such-board", BusSettings{});
  EXPECT_FALSE(absent.open());
  EXPECT_THAT(absent.trouble(), HasSubstr("/dev/no-such-board"));
}

}  // namespace
}  // namespace godobject::test::test_board_bus
