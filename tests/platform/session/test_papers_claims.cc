// Claims of the paper about deformable tools and jaws, on shipped scenes: docs/theory/paper.md.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "platform/simulated/session.h"
#include "tests/support/tool_scene.h"

namespace godobject::test::test_papers_claims {
namespace {

/// Returns a shipped scene whose bodies are placed at the device's pose.
SceneConfig placed_at_the_device(const std::string& name) {
  std::stringstream text;
  text << std::ifstream(GODOBJECT_SOURCE_DIR "/sim/scenes/" + name).rdbuf();
  std::string scene = text.str();
  scene.insert(scene.find("[scene]") + 7, "\ncoupling = \"imposed\"");
  return parse_scene(scene, name).scene.value();
}

/// Runs a scene without buses and calls look(record) after each step; a fault ends the test.
template <class Look>
void run(const SceneConfig& scene, double duration, Look look) {
  const Session::Made made = make_session(scene, Motion(scene), BusChoice::direct);
  ASSERT_NE(made.session, nullptr) << made.errors.front();
  CycleRecord record = made.session->at_start();
  while (record.t < duration - scene.step / 2) {
    made.session->cycle(record);
    ASSERT_EQ(record.fault, Fault::none) << "at " << record.t << " s";
    look(record);
  }
}

Real angle_to_target(const BodyView& body) { return body.X_WB.q.angularDistance(body.target.X_WD.q); }

/// A net on a body that is placed at the device's pose was unstable in fast motion. Here, the device of
/// net-small.toml moves 1 to 100 times as fast, up to 50 m/s.
TEST(PapersClaims, NetOnThePoseOfTheDeviceIsStable) {
  for (const char* const integrator : integrator_names)
    for (const double speed : {1.0, 10.0, 100.0}) {
      SceneConfig scene = placed_at_the_device("net-small.toml");
      scene.integrator = integrator;
      scene.motion->frequency_hz *= speed;
      scene.motion->angle_frequency_hz *= speed;
      double stretch = 0, fastest = 0;
      run(scene, 1, [&](const CycleRecord& record) {
        stretch = std::max(stretch, record.net_stretch);
        fastest = std::max(fastest, record.bodies[0].target.V_WD.v.norm());
      });
      EXPECT_LT(stretch, 1.2) << integrator << ", " << fastest << " m/s";
      EXPECT_GT(fastest, 0.4 * speed) << integrator;
    }
}

/// The deformable tool bent around an obstacle: its bag is dented first, and the rod turns later, when the
/// forces have grown.
TEST(PapersClaims, BagIsDentedBeforeItsRodTurns) {
  SceneConfig scene = load_shipped("endobag.toml");
  scene.integrator = "implicit-euler";
  double touched = -1, dented = -1, turned = -1;  // s
  run(scene, 2.7, [&](const CycleRecord& record) {
    if (touched < 0 && record.nets.num_contacts > 0) touched = record.t;
    if (dented < 0 && record.net_stretch > 1.01) dented = record.t;
    if (touched > 0 && turned < 0 && angle_to_target(record.bodies[0]) > 1e-3) turned = record.t;
  });
  EXPECT_GT(touched, 0);
  EXPECT_GT(dented, touched);
  EXPECT_GT(turned, dented + 0.05);
  std::printf("touched at %.3f s, dented by 1 %% at %.3f s, rod turned by 1 mrad at %.3f s\n", touched,
              dented, turned);
}

/// A simulated jaw on an own coupling opens by the torque of the contact over the coupling's stiffness. An
/// implicit step allows stiffer couplings, which hold it shut; gears need none (TermScenes).
TEST(PapersClaims, SimulatedJawOpensByTorqueOverStiffness) {
  double first = 0;
  for (const double stiffer : {1.0, 30.0}) {
    SceneConfig scene = load_shipped("grasp.toml");
    for (ContactConfig& contact : scene.contacts) contact.law.k = 100;  // soft as an organ
    BodyConfig* jaws[] = {&scene.bodies[*body_named(scene, "left")],
                          &scene.bodies[*body_named(scene, "right")]};
    for (BodyConfig* const jaw : jaws) {
      jaw->coupling->k *= stiffer;
      jaw->coupling->k_r *= stiffer;
      jaw->coupling->g *= std::sqrt(stiffer);
      jaw->coupling->g_r *= std::sqrt(stiffer);
    }
    double opened = 0, expected = 0;
    run(scene, 2, [&](const CycleRecord& record) {
      const BodyView& jaw = record.bodies[*body_named(scene, "left")];
      constexpr double lever = 0.018;  // m, from the hinge to the centre of mass
      const Vec3 to_hinge = jaw.X_WB.q * Vec3(0, 0, lever);
      const double torque = (jaw.contact_W.tau - to_hinge.cross(jaw.contact_W.f)).y();
      opened = angle_to_target(jaw);
      expected = std::abs(torque) / (jaws[0]->coupling->k_r + jaws[0]->coupling->k * lever * lever);
    });
    EXPECT_GT(opened, 1e-3);
    EXPECT_NEAR(opened, expected, 0.1 * expected) << stiffer;
    if (stiffer == 1) first = opened;
    else EXPECT_LT(opened, 0.5 * first);
    std::printf("coupling %.0f times as stiff: opens by %.4f rad\n", stiffer, opened);
  }
}

}  // namespace
}  // namespace godobject::test::test_papers_claims
