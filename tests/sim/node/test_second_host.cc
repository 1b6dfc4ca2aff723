// Frames of a second host: the rig stops its motors and names the bus and the frame.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hal/drive/cia402.h"
#include "tests/support/faulty_rig.h"

namespace godobject::test_second_host {
namespace {

using testing::HasSubstr;

struct Foreign {
  const char* name;
  std::size_t bus;
  CanFrame frame;
  const char* words;
};

std::ostream& operator<<(std::ostream& out, const Foreign& foreign) { return out << foreign.name; }

class SecondHost : public testing::TestWithParam<Foreign> {};

TEST_P(SecondHost, IsSeenByWhatOnlyAHostSends) {
  test::FaultyRig device;
  SimCanPort& other = device.link.rig().attach(GetParam().bus);
  ASSERT_TRUE(device.boot()) << device.rig.fault_text();
  const Nanoseconds later_ns = device.t_sync_ns + 900'000;  // after the commands, when the wire is free
  while (device.link.wait(later_ns) < later_ns) continue;
  ASSERT_EQ(other.try_send(GetParam().frame), SendResult::queued);
  EXPECT_TRUE(device.cycles_to_fault(3)) << "not seen";
  EXPECT_THAT(device.rig.fault_text(), HasSubstr(GetParam().words));
  EXPECT_TRUE(device.cycles_to_zero(7)) << device.motor_torque();
}

INSTANTIATE_TEST_SUITE_P(
    Each, SecondHost,
    testing::Values(Foreign{"sync", 0, canopen::make_sync(), "second_host (can0, identifier 0x080)"},
                    Foreign{"nmt", 0, canopen::make_nmt(canopen::NmtCommand::start, 1),
                            "second_host (can0, identifier 0x000)"},
                    Foreign{"heartbeat", 1, canopen::make_heartbeat(127, canopen::NmtState::operational),
                            "second_host (can1, identifier 0x77f)"},
                    Foreign{"command", 1, cia402::make_command(2, {cia402::enable_operation, 0}),
                            "second_host (can1 node 2, drive of elbow, identifier 0x202)"}),
    [](const auto& each) { return each.param.name; });

// Tools and nodes exchange frames too; the rig ignores frames that any of them may send.
TEST(SecondHost, IsNotWhatOthersMaySend) {
  test::FaultyRig device;
  SimCanPort& other = device.link.rig().attach(1);
  ASSERT_TRUE(device.boot()) << device.rig.fault_text();
  for (const std::uint32_t id : {0x601u, 0x100u, 0x203u, 0x701u + 60, 0x7E5u, 0x83u})
    ASSERT_EQ(other.try_send({.id = id, .size = 1}), SendResult::queued);
  EXPECT_FALSE(device.cycles_to_fault(50)) << device.rig.fault_text();
}

}  // namespace
}  // namespace godobject::test_second_host
