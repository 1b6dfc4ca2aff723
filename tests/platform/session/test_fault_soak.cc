// The fault soak in one process, on simulated buses from end to end. tests/socketcan runs it on the kernel's.
#include "tests/support/fault_soak.h"

namespace godobject::test_fault_soak {
namespace {

TEST(FaultSoak, EveryFaultIsSeenNamedAndRecoveredFrom) {
  test::FaultSoak<SimLink> soak(
      test::fault_reactions(*test::two_joints().device->rig, test::FaultyRig::period_s));
  soak.run(test::soak_seconds(30));
}

}  // namespace
}  // namespace godobject::test_fault_soak
