// Control to display ratio of a relative device: the target's way and the displayed force are scaled alike.
#include <gmock/gmock.h>

#include <algorithm>
#include <array>

#include "platform/scene/toml.h"
#include "platform/session/passivity.h"
#include "platform/simulated/session.h"
#include "tests/support/tool_scene.h"

namespace godobject::test::test_display_ratio {
namespace {

constexpr double ratio = 0.7;

/// A device that shows nothing and keeps the last wrench.
class Listener final : public HandDevice {
 public:
  void read(Period&, std::span<BodySample>) noexcept override {}
  void command(Period&, std::span<const Wrench> F_hand_W, Shown&) noexcept override { F_W = F_hand_W[0]; }
  Wrench F_W;
};

TEST(DisplayRatio, ScalesTheWayOfTheTargetAndTheForceOfTheHand) {
  const auto way = [](double display_ratio) {
    SceneConfig scene = load_shipped("wall.toml");
    scene.device->kind = DeviceKind::relative;
    scene.device->display_ratio = display_ratio;
    Listener listener;
    const Session::Made made = make_session(scene, Motion(scene), BusChoice::direct);
    EXPECT_TRUE(made.session);
    made.session->add(listener);
    CycleRecord record = made.session->at_start();
    const Vec3 start = record.bodies[0].target.X_WD.p;
    Vec3 farthest = Vec3::Zero();
    double largest = 0;
    while (record.t < 2.5) {
      made.session->cycle(record);
      farthest = farthest.cwiseMax((record.bodies[0].target.X_WD.p - start).cwiseAbs());
      const BodyView& peg = record.bodies[0];
      EXPECT_LT((listener.F_W.f - peg.feedback_D.f).norm(), 1e-12);
      EXPECT_LT((listener.F_W.tau - peg.feedback_D.tau).norm(), 1e-12);
      constexpr std::array bounds{Limited::ramp, Limited::force, Limited::force_rate};
      if (std::ranges::any_of(bounds, [&](Limited bound) { return has(record.limited, bound); })) continue;
      // (8), its force scaled as the shift
      const SpringParams& gains = *scene.bodies[0].feedback;
      const Vec3 F_W =
          gains.g * (peg.V_WB.v - peg.target.V_WD.v) + gains.k * (peg.X_WB.p - peg.target.X_WD.p);
      EXPECT_LT((listener.F_W.f - display_ratio * F_W).norm(), 1e-12);
      largest = std::max(largest, listener.F_W.f.norm());
    }
    EXPECT_GT(largest, 0.05);
    return farthest;
  };
  const Vec3 full = way(1), part = way(ratio);
  EXPECT_GT(full.norm(), 0.01);
  EXPECT_LT((part - ratio * full).norm(), 1e-9);
}

/// The stiffness that a drive feels counts the scaled shift and the scaled force.
TEST(DisplayRatio, PassivityCountsItTwice) {
  SceneConfig scene = load_shipped("rigid.toml");
  scene.device->kind = DeviceKind::relative;
  const JointVector q = joints_at_start(scene, Motion(scene));
  const auto K = [&](double display_ratio) {
    scene.device->display_ratio = display_ratio;
    return passivity(scene, q).joints.front().axis.K;
  };
  EXPECT_GT(K(2) - K(1), 1);  // N m/rad or N/m
  EXPECT_NEAR(K(2) - K(1), 4 * (K(1) - K(0.5)), 1e-9 * K(2));
}

TEST(DisplayRatio, IsForRelativeDevicesAlone) {
  const auto errors = [](const char* kind) {
    return parse_scene(std::string("[scene]\nname = 'a'\nabout = 'b'\n[[body]]\nname = 'tool'\nmass = 0.1\n"
                                   "inertia = [1e-4, 1e-4, 1e-4]\n[body.coupling]\nstiffness = 100\n"
                                   "rotational_stiffness = 1\n[device]\nname = 'd'\nkind = '") +
                           kind + "'\ndisplay_ratio = 0.5\n",
                       "a.toml")
        .errors;
  };
  EXPECT_THAT(errors("relative"), testing::IsEmpty());
  EXPECT_THAT(errors("impedance"), testing::ElementsAre(testing::HasSubstr("for a relative device alone")));
}

}  // namespace
}  // namespace godobject::test::test_display_ratio
