// The soak of tests/support/fault_soak.h end to end over virtual CAN interfaces, which fail as well.
#include "tests/support/fault_soak.h"

#include <string_view>

#include "tests/socketcan/vcan_link.h"

namespace godobject::test::test_fault_soak {
namespace {

constexpr const char* interface_down = "interface down bus=can0";
constexpr const char* interface_gone = "interface gone bus=can1";

/// Reactions to the verbs and to the two interface faults. The controller of the wire is not the host's, so
/// the host detects its faults by silence.
std::vector<FaultReaction> reactions() {
  std::vector<FaultReaction> out = fault_reactions(*two_joints().device->rig, FaultyRig::period_s);
  for (FaultReaction& reaction : out)
    if (any(reaction.expected & RigFault::bus_down))
      reaction = {reaction.words, RigFault::sample_stale | RigFault::drive_silent, cycles_of_loss};
  out.push_back({interface_down, RigFault::bus_down, 2});
  out.push_back({interface_gone, RigFault::bus_down, 2});
  return out;
}

class VcanSoak final : public FaultSoak<VcanLink> {
 public:
  VcanSoak() : FaultSoak(reactions()) {}

 private:
  void begin(const FaultReaction& reaction) override {
    interface_fault_ = reaction.words;
    if (interface_fault_ == interface_down) device.link.vcan(0).set("down");
    else if (interface_fault_ == interface_gone) device.link.vcan(1).unplug();
    else FaultSoak::begin(reaction);
  }
  void repair() override {
    if (interface_fault_ == interface_down) device.link.vcan(0).set("up");
    if (interface_fault_ == interface_gone) device.link.vcan(1).plug_in();
    interface_fault_ = {};
    FaultSoak::repair();
  }

  std::string_view interface_fault_;
};

class FaultSoakOverVcan : public CanTest {};

TEST_F(FaultSoakOverVcan, EveryFaultIsSeenNamedAndRecoveredFrom) {
  VcanSoak soak;
  soak.run(soak_seconds(8));
}

}  // namespace
}  // namespace godobject::test::test_fault_soak
