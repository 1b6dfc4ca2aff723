// A loop that misses deadlines holds all bodies, and afterwards none.
#include <gtest/gtest.h>

#include "platform/scene/toml.h"
#include "platform/simulated/session.h"

namespace godobject::test_hold {
namespace {

TEST(Hold, IsOverForBodiesThatNothingLeads) {
  const LoadResult loaded = load_scene(GODOBJECT_SOURCE_DIR "/sim/scenes/lego.toml");
  ASSERT_TRUE(loaded.scene.has_value());
  Session::Made made = make_session(*loaded.scene, Motion(*loaded.scene), BusChoice::direct);
  ASSERT_NE(made.session, nullptr) << made.errors.front();
  Session& session = *made.session;
  CycleRecord record = session.at_start();
  session.start(1);
  for (int i = 0; i < 30; ++i) {
    session.hold(i >= 10 && i < 20);
    ASSERT_TRUE(session.advance(record));
    EXPECT_EQ(has(record.limited, Limited::held), i >= 10 && i < 20) << i;
  }
}

}  // namespace
}  // namespace godobject::test_hold
