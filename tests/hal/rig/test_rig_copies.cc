// Duplicate frames, as made by bridges, gateways and faults.
#include <gtest/gtest.h>

#include <vector>

#include "hal/canopen/cia406.h"
#include "hal/drive/cia402.h"
#include "tests/support/scripted_bus.h"
#include "tests/support/simulated_rig.h"

namespace godobject::test_rig_copies {
namespace {

constexpr Nanoseconds us = 1000;

TEST(RigCopies, LateCopyOfAnAnswerIsNoJump) {
  const RigParams params = test::arm_rig_params();
  test::ScriptedBus encoders, drives;
  const std::vector<CanBus*> buses{&encoders, &drives};
  Rig rig(params, 1e-3, buses);
  rig.start(0);
  const auto answer = [&](std::uint8_t node, std::uint32_t counts, Nanoseconds t) {
    encoders.to_receive.push_back({.frame = cia406::make_position(node, counts), .t_ns = t});
  };
  rig.sync(0);
  answer(1, 1000, 200 * us);
  rig.receive(300 * us);
  rig.sync(1000 * us);
  answer(2, 1000,
         1100 * us);  // was on the wire when SYNC was queued: SYNC may have ended any time until then
  answer(1, 1000, 1200 * us);  // the copy, read as late as answers to this SYNC are
  answer(1, 1040, 1300 * us);  // 15 rad/s in 1 ms, but 150 in the time from copy to answer
  rig.receive(1400 * us);
  EXPECT_EQ(rig.encoder(0).counters().implausible, 0u);
}

// As above, with the position of a drive that is the only sensor of its joint.
TEST(RigCopies, LateCopyOfADrivesAnswerIsNoJump) {
  RigParams params = test::arm_rig_params();
  std::erase_if(params.encoders, [&](const EncoderParams& e) { return e.joint == params.drives[0].joint; });
  test::ScriptedBus encoders, drives;
  const std::vector<CanBus*> buses{&encoders, &drives};
  Rig rig(params, 1e-3, buses);
  rig.start(0);
  const auto answer = [&](std::uint8_t node, std::int32_t counts, Nanoseconds t) {
    drives.to_receive.push_back({.frame = cia402::make_status(node, {0x1637, counts, 0}), .t_ns = t});
  };
  rig.sync(0);
  answer(1, 1000, 200 * us);
  rig.receive(300 * us);
  rig.sync(1000 * us);
  answer(2, 1000, 1100 * us);
  answer(1, 1000, 1200 * us);
  answer(1, 2600, 1300 * us);  // 15 rad/s of the joint in 1 ms
  rig.receive(1400 * us);
  EXPECT_EQ(rig.counters().repeated, 1u);
  EXPECT_TRUE(rig.drive_feedback(0, 1400 * us).position.valid);
  EXPECT_EQ(rig.drive_feedback(0, 1400 * us).state, MotorState::enabled) << "its state counts";
}

}  // namespace
}  // namespace godobject::test_rig_copies
