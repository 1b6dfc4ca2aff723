// Bricks on edges of boxes of the world, alone in their scene and beside an unrelated body. They rest
// in the same place, because the shape of a body meets the world in every type of scene.
#include <gtest/gtest.h>

#include "tests/core/contact/usual_scenes.h"

namespace godobject::test_scene_types {
namespace {

#ifdef NDEBUG
constexpr int draws = 12;
#else
constexpr int draws = 1;  // builds with assertions and sanitizers take a hundred times as long
#endif

template <class I>
struct SceneTypes : ::testing::Test {};
using Integrators = ::testing::Types<ImplicitEuler, TrBdf2>;
TYPED_TEST_SUITE(SceneTypes, Integrators);

/// Puts a brick over the edge of a table and lets it rest. Returns its pose.
template <class S>
Pose rest_over_edge(const Pose& start, const ContactLaw& law, bool beside_another) {
  auto pile = std::make_unique<Pile<S>>();
  set_law(pile->par, law);
  add_box(pile->par, at(Vec3(-0.1, 0, -0.02)), Vec3(0.1, 0.1, 0.02));
  pile->par.gravity_W = Vec3(0, 0, -earth_gravity);
  pile->add_brick({.X_WB = start, .V_WB = {}});
  if (beside_another) pile->add_brick({.X_WB = at(Vec3(5, 0, 0)), .V_WB = {}});
  EXPECT_EQ(validate(pile->par), Invalid::nothing);
  EXPECT_TRUE(pile->run(1.5));
  EXPECT_LT(pile->at(0).v_W.norm(), 1e-6);
  return pile->at(0).X_WB;
}

TYPED_TEST(SceneTypes, ABrickRestsOverAnEdgeAsBesideAnother) {
  Random random(1);
  for (int n = 0; n < draws; ++n) {
    // its centre of mass is over the table, its outer spheres are not
    const Pose start = at(Vec3(random.uniform(-5e-3, -1e-3), random.uniform(-0.05, 0.05), brick_half.z()),
                          Vec3(0, 0, random.uniform(-0.4, 0.4)));
    const Real k = random.log_uniform(1e3, 2e4);
    const ContactLaw law = law_of(k, 0.5, random.uniform(0.3, 0.8));
    const Pose alone = rest_over_edge<OneTool<TypeParam>>(start, law, false);
    const Pose beside = rest_over_edge<FewBodies<TypeParam>>(start, law, true);
    EXPECT_LT((alone.p - beside.p).norm(), 2e-5) << n;
    EXPECT_LT(alone.q.angularDistance(beside.q), 1e-3) << n;
    EXPECT_LT(alone.q.angularDistance(start.q), 0.02) << n << ": tips over";
  }
}

}  // namespace
}  // namespace godobject::test_scene_types
