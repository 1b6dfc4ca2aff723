#include "sim/node/canopen/node.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "hal/canopen/cia406.h"
#include "sim/node/encoder.h"

namespace godobject::test_sim_canopen_node {
namespace {

using canopen::NmtCommand;
using canopen::NmtState;

constexpr Nanoseconds ms = 1'000'000;

struct Network {
  Network() {
    EXPECT_TRUE(host.open() && port_1.open() && port_2.open());
    wire.set_observer(
        {[](void* context, const ReceivedFrame& f) { static_cast<Network*>(context)->log.push_back(f); },
         this});
  }

  void run_to(Nanoseconds t) { advance(wire, nodes, t); }
  void send(const CanFrame& frame) { ASSERT_EQ(host.try_send(frame), SendResult::queued); }
  int count(std::uint32_t id) const {
    return static_cast<int>(std::ranges::count(log, id, [](const ReceivedFrame& f) { return f.frame.id; }));
  }

  SimCanWire wire{{}};
  SimCanPort host{wire}, port_1{wire}, port_2{wire};
  Calibration calibration{.counts_per_unit = 1000};
  SimEncoder one{port_1, 1, calibration, 100 * ms};
  SimEncoder two{port_2, 2, calibration, 0};
  SimCanopenNode* nodes[2] = {&one, &two};
  std::vector<ReceivedFrame> log;
};

TEST(SimCanopenNode, BootsUpAndIsPreOperational) {
  Network net;
  net.run_to(1 * ms);
  ASSERT_EQ(net.log.size(), 2u);
  canopen::Heartbeat heartbeat;
  ASSERT_EQ(canopen::parse_heartbeat(net.log[0].frame, heartbeat), ParseResult::ok);
  EXPECT_EQ(heartbeat.node, 1);
  EXPECT_EQ(heartbeat.state, NmtState::boot_up);
  EXPECT_EQ(net.one.nmt_state(), NmtState::pre_operational);
}

TEST(SimCanopenNode, AnswersSyncInOperationalOnly) {
  Network net;
  net.run_to(1 * ms);
  net.send(canopen::make_sync());
  net.run_to(2 * ms);
  EXPECT_EQ(net.count(0x181), 0);
  net.send(canopen::make_nmt(NmtCommand::start, 1));
  net.send(canopen::make_sync());
  net.run_to(3 * ms);
  EXPECT_EQ(net.count(0x181), 1);
  EXPECT_EQ(net.count(0x182), 0);  // not addressed
  net.send(canopen::make_nmt(NmtCommand::start, 0));
  net.send(canopen::make_sync(5));
  net.run_to(4 * ms);
  EXPECT_EQ(net.count(0x181), 2);
  EXPECT_EQ(net.count(0x182), 1);
  net.send(canopen::make_nmt(NmtCommand::stop, 0));
  net.send(canopen::make_sync());
  net.run_to(5 * ms);
  EXPECT_EQ(net.count(0x181), 2);
  EXPECT_EQ(net.one.nmt_state(), NmtState::stopped);
}

// Both answers wait for the end of SYNC and then follow each other without a gap, lower identifier first.
TEST(SimCanopenNode, AnswersFollowSyncAtOnce) {
  Network net;
  net.run_to(1 * ms);
  net.send(canopen::make_nmt(NmtCommand::start, 0));
  net.run_to(2 * ms);
  net.log.clear();
  net.send(canopen::make_sync());
  net.run_to(3 * ms);
  ASSERT_EQ(net.log.size(), 3u);
  EXPECT_EQ(net.log[1].frame.id, 0x181u);
  EXPECT_EQ(net.log[2].frame.id, 0x182u);
  for (std::size_t i = 1; i < 3; ++i) {
    EXPECT_EQ(net.log[i].t_ns - net.log[i - 1].t_ns, duration_ns(exact_bits(net.log[i].frame), {}));
  }
}

TEST(SimCanopenNode, HeartbeatKeepsItsPeriodAndTellsTheState) {
  Network net;
  net.run_to(550 * ms);
  EXPECT_EQ(net.count(0x701), 1 + 5);
  EXPECT_EQ(net.count(0x702), 1);  // period 0: boot-up only
  EXPECT_EQ(net.log.back().frame.data[0], 127);
  net.send(canopen::make_nmt(NmtCommand::start, 0));
  net.run_to(601 * ms);
  EXPECT_EQ(net.log.back().frame.data[0], 5);
  EXPECT_NEAR(static_cast<double>(net.log.back().t_ns), 600e6, 0.1e6);
}

TEST(SimCanopenNode, ResetBootsAgain) {
  Network net;
  net.run_to(1 * ms);
  net.send(canopen::make_nmt(NmtCommand::start, 0));
  net.run_to(2 * ms);
  net.send(canopen::make_nmt(NmtCommand::reset_node, 1));
  net.run_to(3 * ms);
  EXPECT_EQ(net.log.back().frame.id, 0x701u);
  EXPECT_EQ(net.log.back().frame.data[0], 0);
  EXPECT_EQ(net.one.nmt_state(), NmtState::pre_operational);
  EXPECT_EQ(net.two.nmt_state(), NmtState::operational);
  net.send(canopen::make_nmt(NmtCommand::reset_communication, 2));
  net.run_to(4 * ms);
  EXPECT_EQ(net.log.back().frame.id, 0x702u);
}

TEST(SimCanopenNode, BootUpWaitsForABusThatTakesIt) {
  Network net;
  net.port_1.close();
  net.run_to(1 * ms);
  EXPECT_EQ(net.one.nmt_state(), NmtState::boot_up);
  EXPECT_EQ(net.count(0x701), 0);
  ASSERT_TRUE(net.port_1.open());
  net.run_to(2 * ms);
  EXPECT_EQ(net.count(0x701), 1);
}

}  // namespace
}  // namespace godobject::test_sim_canopen_node
