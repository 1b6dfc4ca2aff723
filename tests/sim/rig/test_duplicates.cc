// Frames that come twice on a full bus of encoders displace no others: nothing is held.
#include <gtest/gtest.h>

#include "tests/support/simulated_rig.h"

namespace godobject::test_duplicates {
namespace {

TEST(Duplicates, DisplaceNothingOnAFullBusOfEncoders) {
  for (const double share : {0.1, 0.5, 1.0}) {
    test::SimulatedRig device;
    ASSERT_TRUE(device.boot() && device.rig->arm()) << device.rig->fault_text();
    static_cast<SimCanPort*>(device.hosts[0])->set_faults({.duplicate = share});
    int held = 0;
    for (int i = 0; i < 5000; ++i) {
      device.cycle();
      held += device.sample.valid && device.sample.fresh ? 0 : 1;
    }
    EXPECT_EQ(held, 0) << share;
    EXPECT_EQ(device.rig->faults(), RigFault::none) << share << device.rig->fault_text();
    EXPECT_GT(device.rig->counters().repeated, 0u) << share;
  }
}

}  // namespace
}  // namespace godobject::test_duplicates
