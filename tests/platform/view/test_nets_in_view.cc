// Nets in the view: their triangles with the scene, their nodes in each frame.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "platform/scene/toml.h"
#include "platform/simulated/session.h"
#include "platform/view/drawing.h"
#include "platform/view/frame.h"

namespace godobject::test_nets_in_view {
namespace {

SceneConfig small() { return *load_scene(GODOBJECT_SOURCE_DIR "/sim/scenes/net-small.toml").scene; }

TEST(NetsInView, TheSceneHasTheirTrianglesAndBounds) {
  const auto json = nlohmann::json::parse(scene_json(small(), {.title = "net"}));
  ASSERT_EQ(json["surfaces"].size(), 1U);
  const auto& surface = json["surfaces"][0];
  EXPECT_EQ(surface["name"], "tube");
  EXPECT_EQ(surface["num_vertices"], 25);
  EXPECT_EQ(surface["triangles"].size(), 3U * 40);
  for (const auto& corner : surface["triangles"]) EXPECT_LT(corner.get<int>(), 25);
  EXPECT_NEAR(surface["bounds"][0][2].get<double>(), -0.0433, 1e-12);
  EXPECT_NEAR(surface["bounds"][1][2].get<double>(), 0.0433, 1e-12);
}

TEST(NetsInView, EachFrameHasTheirNodesAsTheyAre) {
  const SceneConfig scene = small();
  const Session::Made made = make_session(scene, Motion(scene), BusChoice::direct);
  ASSERT_TRUE(made.session);
  CycleRecord record = made.session->at_start();
  ViewTap tap(*made.session);
  for (int i = 0; i < 200; ++i) made.session->cycle(record);
  tap.ask();
  tap.offer(*made.session, record);
  const ViewSample* const sample = tap.get();
  ASSERT_NE(sample, nullptr);
  const std::vector<Vec3> nodes = nodes_of(made.session->engine().nets(), *sample);
  ASSERT_EQ(nodes.size(), 25U);
  EXPECT_GT((nodes[7] - nodes_at_start(scene)[7]).norm(), 1e-3);
  const ViewSample without{.record = record, .counters = {}, .touching = {}};
  EXPECT_GT((nodes[7] - nodes_of(made.session->engine().nets(), without)[7]).norm(), 1e-4)
      << "off its anchor";
  std::vector<std::uint8_t> with_nodes, bare;
  encode(*sample, {}, nodes, with_nodes);
  encode(*sample, {}, {}, bare);
  ASSERT_EQ(with_nodes.size(), bare.size() + 25 * frame_vertex_bytes);
  std::array<float, 3> last{};
  std::memcpy(last.data(), with_nodes.data() + with_nodes.size() - sizeof last, sizeof last);
  for (std::size_t c = 0; c < 3; ++c)
    EXPECT_EQ(last[c], static_cast<float>(nodes[24][static_cast<Eigen::Index>(c)]));
}

}  // namespace
}  // namespace godobject::test_nets_in_view
