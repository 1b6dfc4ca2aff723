// The shipped scenes with contacts run without fault and show the documented behaviour.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "platform/scene/text/csv.h"
#include "platform/scene/toml.h"
#include "platform/simulated/session.h"
#include "tests/support/shared_data.h"

namespace godobject::test_contact_scenes {
namespace {

const std::string scenes = GODOBJECT_SOURCE_DIR "/sim/scenes/";

/// A shipped scene without a bus, with a motion file or its own motion.
class SceneRun {
 public:
  explicit SceneRun(const std::string& name, const std::string& motion = "",
                    const std::string& integrator = "") {
    LoadResult loaded = load_scene(scenes + name);
    EXPECT_THAT(loaded.errors, testing::IsEmpty());
    EXPECT_THAT(loaded.warnings, testing::IsEmpty());
    scene_ = loaded.scene.value();
    if (!integrator.empty()) scene_.integrator = integrator;
    Motion moves(scene_);
    if (!motion.empty()) {
      MotionResult read = Motion::read(motion, scene_);
      EXPECT_THAT(read.errors, testing::IsEmpty());
      moves = read.motion.value();
    }
    Session::Made made = make_session(scene_, std::move(moves), BusChoice::direct);
    if (!made.session) throw std::runtime_error(made.errors.front());
    session_ = std::move(made.session);
    record_ = session_->at_start();
  }

  /// Steps up to time t and calls `look` after each.
  template <class F>
  void until(double t, F look) {
    while (record_.t < t - scene_.step / 2) {
      session_->cycle(record_);
      ASSERT_EQ(record_.fault, Fault::none) << "at " << record_.t << " s";
      look(record_);
    }
  }
  void until(double t) {
    until(t, [](const CycleRecord&) {});
  }

  const SceneConfig& scene() const { return scene_; }
  const BodyView& body(const std::string& name) const {
    return record_.bodies[body_named(scene_, name).value()];
  }
  const CycleRecord& record() const { return record_; }

 private:
  SceneConfig scene_;
  std::unique_ptr<Session> session_;
  CycleRecord record_;
};

TEST(ContactScenes, BounceLeavesThePlaneAndStaysBelowWhereItBegan) {
  SceneRun run("reference/bounce.toml");
  double highest_after = 0, deepest = 0;
  run.until(1.0, [&](const CycleRecord& r) {
    deepest = std::max(deepest, r.contacts.deepest);
    if (deepest > 0 && r.contacts.deepest == 0)
      highest_after = std::max(highest_after, r.bodies[0].X_WB.p.z());
  });
  EXPECT_GT(deepest, 1e-3);
  EXPECT_GT(highest_after, 0.03);
  EXPECT_LT(highest_after, 0.05);
}

/// Returns a ball of a scene file, 1 mm above the plane z = 0.
std::string ball(const std::string& name, double mass, double x, const std::string& velocity) {
  return "[[body]]\nname = \"" + name + "\"\nmass = " + std::to_string(mass) +
         "\ninertia = [4e-6, 4e-6, 4e-6]\nposition = [" + std::to_string(x) +
         ", 0, 0.011]\nvelocity = " + velocity + "\n[[body.sphere]]\nradius = 0.01\n";
}
constexpr const char* ground =
    "[[obstacle]]\nname = \"ground\"\nkind = \"plane\"\n[[contact]]\n"
    "materials = [\"default\", \"default\"]\nstiffness = 5000\n";

/// Thrown at a plane without gravity: balls of all masses leave at the given share of their speed. Implicit
/// Euler damps a half period by pi / 2 h sqrt(k / m) more, 0.7 % of the heavier ball here.
TEST(ContactScenes, BallsReboundWithTheRestitutionOfTheirKey) {
  for (const char* integrator : {"tr-bdf2", "implicit-euler"})
    for (const double restitution : {0.95, 0.7, 0.4, 0.2, 0.05}) {
      const LoadResult loaded = parse_scene(
          "[scene]\nname = \"rebound\"\nstep = 2e-5\nintegrator = \"" + std::string(integrator) + "\"\n" +
              ball("heavy", 0.1, 0, "[0, 0, -0.5]") + ball("light", 0.02, 1, "[0, 0, -0.5]") + ground +
              "restitution = " + std::to_string(restitution) + "\n",
          "rebound.toml");
      ASSERT_THAT(loaded.errors, testing::IsEmpty());
      Session::Made made = make_session(*loaded.scene, Motion(*loaded.scene), BusChoice::direct);
      ASSERT_TRUE(made.session) << made.errors.front();
      CycleRecord record = made.session->at_start();
      for (int n = 0; n < 5000; ++n) made.session->cycle(record);
      const double tolerance = loaded.scene->integrator == "tr-bdf2" ? 1e-3 : 0.008;
      for (std::size_t i = 0; i < 2; ++i)
        EXPECT_NEAR(record.bodies[i].V_WB.v.z() / 0.5, restitution,
                    tolerance * std::sqrt(0.1 / loaded.scene->bodies[i].mass))
            << integrator << ", ball " << i;
      EXPECT_EQ(record.contacts.deepest, 0) << "it has left";
    }
}

/// A light ball that lies far away, before or after two others in the file, does not change how they bounce.
TEST(ContactScenes, ALightBodyElsewhereChangesNoDamping) {
  for (const char* integrator : {"tr-bdf2", "implicit-euler"}) {
    const auto end = [&](bool before, bool after) {
      const std::string light = ball("light", 1e-4, 100, "[0, 0, 1]");
      const LoadResult loaded = parse_scene(
          "[scene]\nname = \"elsewhere\"\nstep = 1e-4\nintegrator = \"" + std::string(integrator) + "\"\n" +
              (before ? light : "") + ball("one", 0.1, 0, "[0.1, 0, -0.5]") +
              ball("two", 0.05, 0.03, "[-0.1, 0, -0.5]") + (after ? light : "") + ground + "friction = 0.5\n",
          "elsewhere.toml");
      EXPECT_THAT(loaded.errors, testing::IsEmpty());
      Session::Made made = make_session(*loaded.scene, Motion(*loaded.scene), BusChoice::direct);
      EXPECT_TRUE(made.session);
      CycleRecord record = made.session->at_start();
      for (int n = 0; n < 2000; ++n) made.session->cycle(record);
      const std::size_t first = before ? 1 : 0;
      return std::array{record.bodies[first].V_WB, record.bodies[first + 1].V_WB};
    };
    const auto alone = end(false, false);
    for (const auto& beside : {end(true, false), end(false, true)})
      for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_LT((alone[i].v - beside[i].v).norm(), 1e-12) << integrator << ", ball " << i;
        EXPECT_LT((alone[i].w - beside[i].w).norm(), 1e-10) << integrator << ", ball " << i;
      }
  }
}

TEST(ContactScenes, PressIsItsReferenceCase) {
  const std::filesystem::path folder = test::shared_file("reference/press");
  if (folder.empty()) GTEST_SKIP() << "shared/reference is not here";
  SceneRun run("reference/press.toml", (folder / "motion.csv").string());
  const CsvTable exact = read_csv((folder / "reference.csv").string()).table.value();
  double worst = 0;
  for (std::size_t row = 1; row < exact.num_rows(); ++row) {
    run.until(exact.at(row, 0));
    worst = std::max(
        worst, (run.body("tool").X_WB.p - Vec3(exact.at(row, 1), exact.at(row, 2), exact.at(row, 3))).norm());
  }
  EXPECT_LT(worst, 1e-5);
}

/// The upper brick rises with the jaws and returns to the lower one, twice.
class GraspScene : public testing::TestWithParam<const char*> {};
TEST_P(GraspScene, LiftsABrickAndPutsItBack) {
  SceneRun run("grasp.toml", "", GetParam());
  for (const double bottom : {0.0, 4.0}) {
    run.until(bottom + 2);
    EXPECT_GT(run.body("upper").X_WB.p.z(), 0.03);
    EXPECT_NEAR(run.body("upper").V_WB.v.z(), 0, 1e-3);
    EXPECT_GT(run.body("left").contact_W.f.norm(), 0.1) << "it is squeezed";
    run.until(bottom + 3.9);
    EXPECT_LT((run.body("upper").X_WB.p - Vec3(0, 0, 0.015)).norm(), 2e-5);
    EXPECT_LT(run.body("upper").V_WB.v.norm(), 1e-6);
    EXPECT_NEAR(run.body("left").contact_W.f.norm(), 0, 1e-9);
  }
  EXPECT_LT((run.body("lower").X_WB.p - Vec3(0, 0, 0.005)).norm(), 2e-5);
}
INSTANTIATE_TEST_SUITE_P(BothIntegrators, GraspScene, testing::ValuesIn(integrator_names));

#ifdef NDEBUG
TEST(ContactScenes, LegoTakesTwoBricksAndPutsOneOnTheOther) {
  SceneRun run("lego.toml", scenes + "lego-motion.csv");
  run.until(4.0);
  EXPECT_LT((run.body("red").X_WB.p - Vec3(0, 0.16, 0.005)).norm(), 1e-4);
  run.until(9.0);
  EXPECT_FALSE(run.record().held);
  EXPECT_LT((run.body("red").X_WB.p - Vec3(0, 0.16, 0.005)).norm(), 1e-4);
  EXPECT_LT((run.body("blue").X_WB.p - Vec3(0, 0.16, 0.015)).norm(), 1e-4);
  EXPECT_LT(run.body("blue").V_WB.v.norm(), 1e-6);
  run.until(10.0);
  EXPECT_EQ(run.record().held, body_named(run.scene(), "mover"));
}
#endif

TEST(ContactScenes, LegoDragsABrickThroughThePile) {
  SceneRun run("lego.toml");
  double deepest = 0, farthest = 0;
  run.until(1.2, [&](const CycleRecord& r) {
    deepest = std::max(deepest, r.contacts.deepest);
    farthest = std::max(farthest, r.following.m);
  });
  double pushed = 0;
  for (std::size_t i = 0; i < run.scene().bodies.size(); ++i)
    if (!run.scene().bodies[i].coupling)
      pushed = std::max(pushed, (run.record().bodies[i].X_WB.p - run.scene().bodies[i].X_WB.p).norm());
  EXPECT_GT(pushed, 0.01);
  EXPECT_LT(deepest, 5e-4);
  EXPECT_GT(farthest, 1e-4) << "bricks in the way hold it back";
}

/// Fig. 7 of the paper: the tool slides along the surface, the device enters.
TEST(ContactScenes, OrganKeepsTheToolOutWhereTheDeviceGoesIn) {
  SceneRun run("organ.toml");
  // Returns the position relative to the shell of the spheres' centres: 1 on it, below 1 inside.
  const auto inside = [](const Vec3& p) {
    return (p - Vec3(0, 0, 0.225)).cwiseQuotient(Vec3(0.045, 0.055, 0.035)).norm();
  };
  const auto tip = [](const Pose& X) { return Vec3(X.p + X.q * Vec3(0, 0, 0.01)); };
  double device = 10, tool = 10, deepest = 0;
  std::size_t most = 0;
  run.until(4.0, [&](const CycleRecord& r) {
    const BodyView& jaw = r.bodies[*body_named(run.scene(), "left")];
    device = std::min(device, inside(tip(jaw.target.X_WD)));
    tool = std::min(tool, inside(tip(jaw.X_WB)));
    deepest = std::max(deepest, r.contacts.deepest);
    most = std::max(most, r.contacts.num_contacts);
  });
  std::printf("organ: device's jaw to %.2f, tool's to %.2f of the shell; %zu contacts, %.2g m deep\n", device,
              tool, most, deepest);
  EXPECT_LT(device, 1.3);
  EXPECT_GT(tool, 1.4);
  EXPECT_GT(most, 3u);
  EXPECT_LT(deepest, 8e-3);
  EXPECT_LT(run.record().following.m, 1e-4) << "beyond the organ the tool is with the device again";
}

TEST(ContactScenes, FilesAreWhatTheirScriptsWrite) {
  if (std::system("python3 -c '' 2> /dev/null") != 0) GTEST_SKIP() << "python3 is not here";
  for (const auto& [script, file] :
       {std::pair{"lego_motion.py", "lego-motion.csv"}, {"organ_spheres.py", "organ-spheres.csv"}}) {
    const std::string command = "cd '" + scenes + "' && python3 " + script + " | cmp - " + file;
    EXPECT_EQ(std::system(command.c_str()), 0) << file;
  }
}

}  // namespace
}  // namespace godobject::test_contact_scenes
