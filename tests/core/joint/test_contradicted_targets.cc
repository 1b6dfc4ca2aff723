// Tools whose targets contradict their joints: couplings pull each body away from its place on the others.
// They come to rest at any stiffness.
#include <memory>

#include <gtest/gtest.h>

#include "tests/core/joint/contradicted_tree.h"
#include "tests/core/joint/grasper_tool.h"
#include "tests/core/joint/usual_scene.h"

namespace godobject::test_contradicted_targets {
namespace {

template <class I>
class ContradictedTargets : public ::testing::Test {};
TYPED_TEST_SUITE(ContradictedTargets, BothIntegrators);

TYPED_TEST(ContradictedTargets, RandomTreesComeToRest) {
  for (unsigned seed = 0; seed < 1000; ++seed) {
    const PulledApart c = pulled_apart<TypeParam>(seed);
    SCOPED_TRACE(testing::Message() << "seed " << seed << ", h " << c.h << " s, " << c.k << " N/m, off by "
                                    << c.offset);
    EXPECT_FALSE(c.fault);
    EXPECT_LT(c.fastest, 1e-6);
    EXPECT_LT(c.drift, 1e-9);
  }
}

}  // namespace
}  // namespace godobject::test_contradicted_targets
