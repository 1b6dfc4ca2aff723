#include "sim/fault/target.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "platform/scene/toml.h"
#include "platform/simulated/session.h"
#include "tests/support/faulty_rig.h"

namespace godobject::test_fault_target {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const RigParams& rig() {
  static const SceneConfig scene = test::two_joints();
  return *scene.device->rig;
}

SimFault resolved(std::string_view words) {
  std::string error;
  const std::optional<FaultConfig> config = parse_fault(words, error);
  const FaultResult found = config ? resolve(*config, rig()) : FaultResult{};
  EXPECT_TRUE(found.fault) << words << ": " << error << found.error;
  return found.fault.value_or(SimFault{});
}

std::string complaint(std::string_view words) {
  std::string error;
  const std::optional<FaultConfig> config = parse_fault(words, error);
  return config ? resolve(*config, rig()).error : error;
}

TEST(FaultTarget, FindsNodeOnItsBus) {
  const SimFault fault = resolved("drop bus=can1 node=2 value=0.25 duration=0.5 at=1.5");
  EXPECT_EQ(fault.verb, FaultVerb::drop);
  EXPECT_EQ(fault.first_bus, 1u);
  EXPECT_EQ(fault.end_bus, 2u);
  EXPECT_EQ(fault.node_id, 2);
  EXPECT_EQ(fault.value, 0.25);
  EXPECT_EQ(fault.duration_ns, 500'000'000);
  EXPECT_EQ(fault.at, 1.5);
}

TEST(FaultTarget, WithoutNodeAndBusMeansTheHostsEndOfAllBuses) {
  const SimFault fault = resolved("unplug");
  EXPECT_EQ(fault.node_id, 0);
  EXPECT_EQ(fault.first_bus, 0u);
  EXPECT_EQ(fault.end_bus, 2u);
  EXPECT_FALSE(fault.duration_ns);
}

TEST(FaultTarget, TakesTheVerbsOwnValueWhereNoneIsGiven) {
  EXPECT_EQ(resolved("drop bus=can0").value, 1);
  EXPECT_EQ(resolved("emcy bus=can1 node=1").value, 0x1000);
}

TEST(FaultTarget, SaysWhatIsWrong) {
  EXPECT_THAT(complaint("dorp"), HasSubstr("unknown verb 'dorp'"));
  EXPECT_THAT(complaint("drop bus=can7"), HasSubstr("unknown bus 'can7'"));
  EXPECT_THAT(complaint("drop bus=can0 node=9"), HasSubstr("no node 9"));
  EXPECT_THAT(complaint("stuck node=1"), HasSubstr("more than one bus"));
  EXPECT_THAT(complaint("stuck bus=can0"), HasSubstr("one node"));
  EXPECT_THAT(complaint("drop value=1.5"), HasSubstr("must be from 0.0 to 1.0"));
  EXPECT_THAT(complaint("drop value=much"), HasSubstr("must be a number"));
  EXPECT_THAT(complaint("drop node=0"), HasSubstr("out of range"));
  EXPECT_THAT(complaint("drop can0"), HasSubstr("key=value"));
  EXPECT_THAT(complaint("press bus=can0 node=1"), HasSubstr("node 1 has no button at input 1"));
  EXPECT_THAT(complaint("  "), HasSubstr("expected a verb"));
}

TEST(FaultFile, ReadsTables) {
  const FaultsResult result = parse_faults(R"(
[[fault]]
verb = "bus-off"
bus = "can0"
node_id = 2
at = 2.0
duration = 0.5
[[fault]]
verb = "delay"
value = 1e-3
)",
                                           "faults.toml", test::two_joints(), simulated_faults());
  EXPECT_THAT(result.errors, IsEmpty());
  ASSERT_EQ(result.faults.size(), 2u);
  EXPECT_EQ(result.faults[0].node_id, 2);
  EXPECT_EQ(result.faults[0].duration, 0.5);
  EXPECT_FALSE(result.faults[1].node_id);
  EXPECT_EQ(result.faults[1].value, 1e-3);
}

TEST(FaultFile, NamesThePlaceOfAnError) {
  const FaultsResult result = parse_faults("[[fault]]\nverb = \"stuck\"\nbus = \"can0\"\nnode_id = 9\n",
                                           "faults.toml", test::two_joints(), simulated_faults());
  EXPECT_THAT(result.errors, ElementsAre(testing::AllOf(HasSubstr("faults.toml:2"), HasSubstr("no node 9"))));
}

TEST(FaultFile, SceneHasTheSameTables) {
  const std::string toml = std::string(test::two_joints_toml) + "[[fault]]\nverb = \"unplug\"\nat = 1.0\n";
  const LoadResult loaded = parse_scene(toml, "scene", simulated_faults());
  ASSERT_THAT(loaded.errors, IsEmpty());
  ASSERT_EQ(loaded.scene->faults.size(), 1u);
  const LoadResult again = parse_scene(effective_config_toml(*loaded.scene), "printed", simulated_faults());
  ASSERT_THAT(again.errors, IsEmpty());
  EXPECT_EQ(effective_config_toml(*again.scene), effective_config_toml(*loaded.scene));
}

TEST(FaultFile, OfWhoDoesNotSimulateIsCheckedBySimulatedDevices) {
  const std::string toml = std::string(test::two_joints_toml) + "[[fault]]\nverb = \"dorp\"\nat = 1.0\n";
  EXPECT_THAT(parse_scene(toml, "scene", simulated_faults()).errors, ElementsAre(HasSubstr("scene:")));
  const LoadResult loaded = parse_scene(toml, "scene");
  ASSERT_THAT(loaded.errors, IsEmpty());
  EXPECT_THAT(make_session(*loaded.scene, Motion(*loaded.scene), BusChoice::sim).errors,
              ElementsAre(HasSubstr("fault 'dorp' cannot be played: unknown verb 'dorp'")));
}

}  // namespace
}  // namespace godobject::test_fault_target
