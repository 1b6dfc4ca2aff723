// The simulated rig behind real buses, with buses and a clock of the test's own.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <deque>

#include "hal/canopen/canopen.h"
#include "platform/cli/simulate/simulation.h"
#include "tests/support/faulty_rig.h"

namespace godobject::test_simulate {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::SizeIs;

constexpr Nanoseconds ms = 1'000'000;

/// A bus that the bridge takes for a real one.
class FakeBus final : public LinuxBus {
 public:
  bool open() noexcept override { return true; }
  void close() noexcept override {}
  SendResult try_send(const CanFrame& frame) noexcept override {
    if (answer == SendResult::queued) sent.push_back(frame);
    return answer;
  }
  bool try_receive(ReceivedFrame& out) noexcept override {
    if (arrived.empty()) return false;
    out = {.frame = arrived.front(), .t_ns = 0};
    arrived.pop_front();
    return true;
  }
  BusState state() const noexcept override { return BusState::error_active; }
  BusCounters counters() const noexcept override { return {}; }
  int descriptor() const noexcept override { return -1; }
  std::string trouble() const override { return ""; }

  std::deque<CanFrame> arrived;
  std::vector<CanFrame> sent;
  SendResult answer = SendResult::queued;
};

class SimulateTest : public testing::Test {
 protected:
  explicit SimulateTest(SceneConfig scene = test::two_joints()) : scene_(std::move(scene)), motion_(scene_) {
    std::vector<OfferedBus> offered;
    for (const bool is_tap : {false, true}) {
      for (std::size_t wire = 0; wire < 2; ++wire) {
        auto bus = std::make_unique<FakeBus>();
        (is_tap ? taps_ : buses_).push_back(bus.get());
        offered.push_back({.name = scene_.device->rig->buses[wire].name,
                           .address = "fake",
                           .wire = wire,
                           .is_tap = is_tap,
                           .bus = std::move(bus)});
      }
    }
    simulation_ = std::make_unique<Simulation>(scene_, RigProfiles(), motion_, std::move(offered), true);
  }

  void run_until(Nanoseconds t) {
    while (now_ < t) {
      now_ = std::min(t, std::max(now_ + 1000, simulation_->next_step()));
      simulation_->step(now_);
    }
  }
  nlohmann::json say(const std::string& line) {
    return nlohmann::json::parse(answer(line, *simulation_, quit_));
  }

  SceneConfig scene_;
  Motion motion_;
  std::vector<FakeBus*> buses_, taps_;
  std::unique_ptr<Simulation> simulation_;
  Nanoseconds now_ = 0;
  bool quit_ = false;
};

auto has_id(std::uint32_t id) { return testing::Field(&CanFrame::id, id); }

TEST_F(SimulateTest, NodesBootOnTheBus) {
  run_until(2 * ms);
  EXPECT_THAT(buses_[0]->sent, Contains(has_id(canopen::heartbeat_cob_id(1))));
  EXPECT_THAT(buses_[1]->sent, Contains(has_id(canopen::heartbeat_cob_id(2))));
}

TEST_F(SimulateTest, AnswersSyncAfterTheFramesOwnTimeOnTheWire) {
  buses_[0]->arrived.push_back(canopen::make_nmt(canopen::NmtCommand::start, 0));
  run_until(5 * ms);
  buses_[0]->sent.clear();
  buses_[0]->arrived.push_back(canopen::make_sync());
  run_until(5 * ms + 40'000);
  EXPECT_TRUE(buses_[0]->sent.empty()) << "SYNC alone takes 44 bits at least";
  run_until(6 * ms);
  EXPECT_THAT(buses_[0]->sent, Contains(has_id(canopen::tpdo_cob_id(1, 1))));
  EXPECT_THAT(buses_[0]->sent, Contains(has_id(canopen::tpdo_cob_id(1, 2))));
}

TEST_F(SimulateTest, MotionBeginsWithTheFirstSync) {
  run_until(20 * ms);
  EXPECT_EQ(simulation_->motion_time(), 0);
  buses_[1]->arrived.push_back(canopen::make_sync());
  run_until(30 * ms);
  EXPECT_NEAR(simulation_->motion_time(), 0.010, 1.1e-3)
      << "it is seen with the next event, at most a period later";
}

class HomedSimulateTest : public SimulateTest {
 protected:
  HomedSimulateTest() : SimulateTest(incremental()) {}
  static SceneConfig incremental() {
    SceneConfig scene = test::two_joints();
    scene.device->rig->encoders[0].calibration = {.counts_per_unit = 1000, .incremental = true};
    scene.device->rig->buttons.push_back({.use = ButtonUse::home, .node_id = 3, .bit = 1});
    return scene;
  }
  void run_with_sync_until(Nanoseconds t) {
    while (now_ < t) {
      buses_[0]->arrived.push_back(canopen::make_sync());
      run_until(now_ + 50 * ms);
    }
  }
};

// The hand homes the device while the host boots, also when it boots again after the end of a run.
TEST_F(HomedSimulateTest, MotionWaitsForTheHandThatHomes) {
  run_with_sync_until(2900 * ms);
  EXPECT_EQ(simulation_->motion_time(), 0);
  run_with_sync_until(3500 * ms);
  EXPECT_NEAR(simulation_->motion_time(), 0.5, 2e-3);
  run_until(3700 * ms);
  run_with_sync_until(3750 * ms);
  const double before_s = simulation_->motion_time();
  EXPECT_NEAR(before_s, 0.7, 2e-3);
  run_with_sync_until(6600 * ms);
  EXPECT_EQ(simulation_->motion_time(), before_s);
  run_with_sync_until(7000 * ms);
  EXPECT_NEAR(simulation_->motion_time(), before_s + 0.3, 2e-3);
}

TEST_F(SimulateTest, TapHearsTheHostAndSpeaksAsANode) {
  buses_[0]->arrived.push_back(canopen::make_nmt(canopen::NmtCommand::start, 0));
  taps_[0]->arrived.push_back({.id = 0x123, .size = 1});
  run_until(2 * ms);
  EXPECT_THAT(taps_[0]->sent, Contains(has_id(canopen::nmt_cob_id)));
  EXPECT_THAT(taps_[0]->sent, Not(Contains(has_id(0x123))));
  EXPECT_THAT(buses_[0]->sent, Contains(has_id(0x123)));
  EXPECT_THAT(taps_[1]->sent, Not(Contains(has_id(0x123))));
}

TEST_F(SimulateTest, FrameWaitsForAFullBusButNotForEver) {
  buses_[0]->answer = SendResult::full;
  run_until(5 * ms);
  buses_[0]->answer = SendResult::queued;
  run_until(6 * ms);
  EXPECT_THAT(buses_[0]->sent, SizeIs(3)) << "the boot-up messages of all nodes";
  buses_[0]->answer = SendResult::full;
  run_until(400 * ms);
  EXPECT_GT(simulation_->to_json()["buses"][0]["dropped"], 0);
}

TEST_F(SimulateTest, PlaysFaultsByWord) {
  EXPECT_EQ(say("fault unplug bus=can0 node=1")["ok"], true);
  run_until(10 * ms);
  const nlohmann::json status = say("status");
  ASSERT_THAT(status["faults"], SizeIs(1));
  EXPECT_EQ(status["faults"][0]["verb"], "unplug");
  EXPECT_EQ(status["faults"][0]["bus"], "can0");
  EXPECT_GT(status["faults"][0]["begun_at_s"], 0);
  EXPECT_EQ(say("clear")["ok"], true);
  EXPECT_TRUE(say("status")["faults"].empty());
}

TEST_F(SimulateTest, RefusesWhatItDoesNotKnow) {
  for (const char* line : {"", "fault", "fault dorp", "fault drop bus=can9", "jump", "fault stuck"}) {
    const nlohmann::json reply = say(line);
    EXPECT_EQ(reply["ok"], false) << line;
    EXPECT_FALSE(reply["error"].get<std::string>().empty()) << line;
  }
  EXPECT_FALSE(quit_);
  EXPECT_EQ(say("quit")["ok"], true);
  EXPECT_TRUE(quit_);
}

/// Lines of a pipe, as read by the control of a simulation.
TEST(LineInput, ALineIsOneHoweverLong) {
  for (const std::size_t size : {999u, 1000u, 1001u, 1100u, 4095u, 40'000u}) {
    std::array<int, 2> ends{};
    ASSERT_EQ(pipe2(ends.data(), O_NONBLOCK), 0);
    LineInput input(ends[0]);
    const std::string text = "before\n" + std::string(size, 'x') + "\nafter\n" + std::string(size, 'y');
    std::vector<std::string> lines;
    const auto take = [&] {
      for (std::string line; input.try_line(line);) lines.push_back(line);
    };
    for (std::size_t at = 0; at < text.size(); at += 1000) {
      const std::string part = text.substr(at, 1000);
      ASSERT_EQ(write(ends[1], part.data(), part.size()), static_cast<ssize_t>(part.size()));
      take();
    }
    close(ends[1]);
    take();
    ASSERT_THAT(lines, SizeIs(4)) << size;
    EXPECT_EQ(lines[0], "before");
    EXPECT_EQ(lines[1].size() >= LineInput::max_line, size > 1000);
    EXPECT_EQ(lines[2], "after");
    EXPECT_EQ(input.descriptor(), -1);
    close(ends[0]);
  }
}

TEST_F(SimulateTest, RefusesALineThatIsTooLong) {
  const nlohmann::json reply = say("status" + std::string(2000, ' '));
  EXPECT_EQ(reply["ok"], false);
  EXPECT_LT(reply.dump().size(), 200u);
}

}  // namespace
}  // namespace godobject::test_simulate
