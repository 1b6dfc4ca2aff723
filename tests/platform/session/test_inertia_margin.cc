// [device.compensation] inertia in the margins of `godobject check`, and its keys.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "platform/scene/toml.h"
#include "platform/session/passivity.h"
#include "tests/support/desk_scene.h"

namespace godobject::test_inertia_margin {
namespace {

using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Returns the desk without feedback, of 0.3 kg, with these keys of [device.compensation].
std::string desk(const std::string& damping, const std::string& keys) {
  return test::desk_scene("scale = 0\n",
                          "inertia = 0.3\ndamping = " + damping + "\n[device.compensation]\n" + keys);
}

SceneConfig parsed(const std::string& text) {
  const LoadResult loaded = parse_scene(text, "desk.toml");
  EXPECT_THAT(loaded.errors, IsEmpty());
  return *loaded.scene;
}

Passivity margin(const SceneConfig& scene) {
  return worst_passivity(scene, joints_at_start(scene, Motion(scene)));
}

TEST(InertiaMargin, AMovedInertiaNeedsDampingOfTheDevice) {
  EXPECT_THAT(margin(parsed(desk("5", ""))).joints, IsEmpty());
  const SceneConfig scene = parsed(desk("5", "inertia = 0.5\n"));
  const Passivity result = margin(scene);
  const SampledAxis axis = result.joints.front().axis;
  EXPECT_DOUBLE_EQ(axis.carried, 0.15);
  EXPECT_NEAR(axis.cutoff, 31.4159, 1e-3);
  // m_c w_c / 2 of the filter, at w_c
  EXPECT_NEAR(axis.needed(), 0.5 * 0.15 * axis.cutoff, 0.02 * 0.15 * axis.cutoff);
  EXPECT_DOUBLE_EQ(result.joints.front().needed, axis.needed());
  EXPECT_TRUE(result.passive());
  EXPECT_THAT(passivity_warnings(result), IsEmpty());
  EXPECT_FALSE(passivity_controllers(scene, JointVector::Zero(3)).front().is_active());
}

TEST(InertiaMargin, BeyondItTheAxisHasAControllerAndTheWarningNamesTheKey) {
  const SceneConfig scene = parsed(desk("1", "inertia = 0.5\n"));
  const std::vector<std::string> warnings = passivity_warnings(margin(scene));
  EXPECT_THAT(warnings, Each(HasSubstr("lower inertia in [device.compensation] to ")));
  const PassivityParams controller = passivity_controllers(scene, JointVector::Zero(3)).front();
  EXPECT_TRUE(controller.is_active());
  EXPECT_DOUBLE_EQ(controller.carried, 0.15);
  // the percentage of the warning is enough
  const std::size_t at = warnings.front().find("[device.compensation] to ") + 25;
  const double percent = std::stod(warnings.front().substr(at));
  const std::string mended = "inertia = " + std::to_string(0.5 * 0.01 * percent) + "\n";
  EXPECT_THAT(passivity_warnings(margin(parsed(desk("1", mended)))), IsEmpty());
  EXPECT_GT(percent, 30);
}

std::vector<std::string> errors_of(const std::string& text) { return parse_scene(text, "desk.toml").errors; }

TEST(InertiaMargin, SharesThatCannotActAreRefused) {
  EXPECT_THAT(errors_of(desk("1", "inertia = 0.9\ninertia_cutoff = 8\n")), IsEmpty());
  for (const std::string share : {"1.0", "-0.1", "0.95", "nan"})
    EXPECT_THAT(errors_of(desk("1", "inertia = " + share + "\n")), ElementsAre(HasSubstr("'inertia'")))
        << share;
  EXPECT_THAT(errors_of(desk("1", "inertia = 0.5\ninertia_cutoff = 0\n")),
              ElementsAre(HasSubstr("'inertia_cutoff'")));
  EXPECT_THAT(errors_of("[scene]\nname = \"a\"\n[[body]]\nname = \"b\"\nmass = 1\ninertia = [1, 1, 1]\n"
                        "[body.coupling]\nstiffness = 10\nrotational_stiffness = 1\n"
                        "[device]\nname = \"d\"\n[device.compensation]\ninertia = 0.5\n"),
              ElementsAre(HasSubstr("needs drives: add [[device.drive]]")));
}

}  // namespace
}  // namespace godobject::test_inertia_margin
