// A slow simulation around the tool: the force of one process, no gain of energy in spite of jitter, silence,
// and packets that are none.
#include "platform/session/world.h"

#include <gmock/gmock.h>

#include <limits>

#include "platform/scene/toml.h"
#include "platform/simulated/session.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/slow_world.h"

namespace godobject::test_world {
namespace {

using test::Block;
using test::SlowWorld;
using test::world_clock_ns;

constexpr double k_contact = 1000, c_contact = 5;  // of each of the peg's four corners

/// The peg of wall.toml without its wall, moved along x about `centre`.
SceneConfig peg(double centre, double amplitude, double frequency_hz) {
  SceneConfig scene = *load_scene(GODOBJECT_SOURCE_DIR "/sim/scenes/wall.toml").scene;
  scene.obstacles.clear();
  scene.contacts.clear();
  scene.motion = MotionConfig{};
  scene.motion->X_WD.p = Vec3(centre, 0, 0);
  scene.motion->amplitude = Vec3(amplitude, 0, 0);
  scene.motion->frequency_hz = Vec3(frequency_hz, 0, 0);
  scene.motion->phase = Vec3(-pi / 2, 0, 0);
  scene.bodies[0].X_WB.p = Vec3(centre - amplitude, 0, 0);
  scene.device->limits.ramp = 0;
  return scene;
}

/// Returns a large box of this half width along x.
ShapeConfig box(double half, const Vec3& p) {
  ShapeConfig shape;
  shape.X.p = p;
  shape.half_extents = Vec3(half, 0.3, 0.3);
  return shape;
}

/// Adds the block as a body of the scene, in one process.
void add_block(SceneConfig& scene, const Block& block) {
  constexpr double half = 0.05;
  BodyConfig body;
  body.name = "block";
  body.mass = block.mass;
  body.inertia = Mat3::Identity() * 1e-2;
  body.X_WB.p = Vec3(block.x + half, 0, 0);
  body.is_placed = true;
  body.shapes.push_back(box(half, Vec3::Zero()));
  scene.bodies.push_back(body);
  JointConfig slide;
  slide.name = "slide";
  slide.kind = JointKind::slider;
  slide.child = "block";
  slide.coordinates = {"x"};
  slide.X_BP.p = Vec3(block.rest + half, 0, 0);
  slide.X_BP.q = slide.X_BC.q = Quat(Eigen::AngleAxisd(pi / 2, Vec3::UnitY()));  // its z axis is x
  slide.springs.push_back({.coordinate = "x", .k = block.k, .g = block.g});
  scene.joints.push_back(slide);
  scene.contacts.push_back(
      {.materials = {default_material, default_material}, .law = {.k = k_contact, .c = c_contact}});
}

/// A session beside a slow world, in steps of both.
class Pair {
 public:
  Pair(SceneConfig scene, const Block& block, const WorldLimits& limits = {}) {
    world_clock_ns = 1'000'000'000;
    scene.world_planes = max_world_planes;
    world.block = block;
    world.k = k_contact;
    world.c = c_contact;
    made_ = make_session(scene, Motion(scene), BusChoice::direct);
    EXPECT_TRUE(made_.session) << made_.errors.front();
    planes.emplace(made_.session->scene(), made_.session->engine(), world, test::read_world_clock, limits);
    made_.session->add(*planes);
    made_.session->start(1);
    record = made_.session->at_start();
  }
  void step() {
    world_clock_ns += 1'000'000;
    ASSERT_TRUE(made_.session->advance(record));
    fault = fault | record.fault;
  }
  void step(int n) {
    for (int i = 0; i < n; ++i) step();
  }
  /// Returns the force of the planes on the tool, N.
  double force() const { return -world.tool.f_W_N[0]; }
  Session& session() { return *made_.session; }

  SlowWorld world;
  std::optional<WorldPlanes> planes;
  CycleRecord record;
  Fault fault = Fault::none;

 private:
  Session::Made made_;
};

/// Result of a comparison with the run in one process.
struct Compared {
  double worst_share = 0, rms_share = 0;  // of the largest force
  double largest = 0;                     // N
};

/// Runs the scene beside the block, in one process and with the slow world.
Compared compare(const Block& block, double amplitude, double frequency_hz, double jitter_s) {
  const SceneConfig alone = peg(0, amplitude, frequency_hz);
  SceneConfig both = alone;
  if (block.is_fixed) {
    ObstacleConfig& wall = both.obstacles.emplace_back();
    wall.name = "wall";
    wall.shape = box(0.05, Vec3(block.x + 0.05, 0, 0));
    both.contacts.push_back(
        {.materials = {default_material, default_material}, .law = {.k = k_contact, .c = c_contact}});
  } else {
    add_block(both, block);
  }
  Session::Made one = make_session(both, Motion(both), BusChoice::direct);
  EXPECT_TRUE(one.session) << one.errors.front();
  CycleRecord record = one.session->at_start();
  Pair pair(alone, block);
  pair.world.jitter_s = jitter_s;
  Compared result;
  std::vector<double> of_one, of_two;
  for (int i = 0; i < 8000; ++i) {
    one.session->cycle(record);
    pair.step();
    of_one.push_back(-one.session->engine().view(0).contact_W.f.x());
    of_two.push_back(pair.force());
    result.largest = std::max(result.largest, of_one.back());
  }
  double sum = 0;
  for (std::size_t i = 0; i < of_one.size(); ++i) {
    const double error = std::abs(of_one[i] - of_two[i]) / result.largest;
    result.worst_share = std::max(result.worst_share, error);
    sum += error * error;
  }
  result.rms_share = std::sqrt(sum / static_cast<double>(of_one.size()));
  EXPECT_FALSE(any(pair.fault));
  EXPECT_EQ(pair.planes->counters().malformed, 0u);
  std::printf("force: worst %.2f %%, rms %.2f %% of %.2f N; held back in %llu steps\n",
              100 * result.worst_share, 100 * result.rms_share, result.largest,
              static_cast<unsigned long long>(pair.planes->counters().limited));
  return result;
}

TEST(SlowWorld, AWallHasTheForceOfOneProcess) {
  const Compared of = compare({.x = 0.035, .is_fixed = true}, 0.04, 0.5, 0.03);
  EXPECT_GT(of.largest, 5);
  EXPECT_LT(of.worst_share, 0.05);
}

TEST(SlowWorld, ABlockOnASpringHasTheForceOfOneProcess) {
  Block block{.mass = 0.5, .k = 400, .g = 40, .rest = 0.035, .x = 0.035};
  for (const double frequency_hz : {0.1, 0.25}) {
    const Compared of = compare(block, 0.04, frequency_hz, 0.03);
    EXPECT_GT(of.largest, 3);
    EXPECT_LT(of.rms_share, 0.05);
  }
  block.g = 20;  // bears less delay (docs/how-to/slow-world.md)
  EXPECT_LT(compare(block, 0.04, 0.25, 0).rms_share, 0.05);
  EXPECT_LT(compare(block, 0.04, 0.25, 0.03).rms_share, 0.1);
}

/// Returns the largest rise of energy of tool and block, J, in 20 s. The hand holds its target at rest where
/// an undamped block swings.
double largest_rise(const Block& block, double jitter_s, const WorldLimits& limits = {}) {
  Pair pair(peg(block.rest, 0, 0), block, limits);
  pair.world.jitter_s = jitter_s;
  pair.step(300);
  double least = std::numeric_limits<double>::infinity(), rise = 0;
  for (int i = 0; i < 20'000 && rise < 10; ++i) {
    pair.step();
    const double energy = pair.record.energy.total + pair.world.block.energy();
    least = std::min(least, energy);
    rise = std::max(rise, energy - least);
  }
  std::printf("energy: rises by %.2g J, held back in %llu steps\n", rise,
              static_cast<unsigned long long>(pair.planes->counters().limited));
  if (limits.allowance_J < 1) {
    EXPECT_FALSE(any(pair.fault));
  }
  return rise;
}

Block swinging(double mass, double k) { return {.mass = mass, .k = k, .rest = 0.02, .x = 0.03}; }

TEST(SlowWorld, GainsNoEnergyAt60HzAnd30MsOfJitter) {
  const double most = 2.5 * WorldLimits{}.allowance_J;
  for (const double jitter_s : {0.0, 0.03})
    for (const auto& [mass, k] : {std::pair(0.5, 200.0), std::pair(0.2, 100.0), std::pair(2.0, 50.0)})
      EXPECT_LT(largest_rise(swinging(mass, k), jitter_s), most) << mass << " kg, " << k << " N/m";
  EXPECT_GT(largest_rise(swinging(0.5, 200), 0.03, {.allowance_J = 1e9}), 1) << "without its controller";
}

/// A pair whose peg was pushed away by a wall, which then stands.
class Pressed : public testing::Test {
 protected:
  void SetUp() override {
    pair.world.jitter_s = 0;
    while (pair.world.block.x > 0.035) pair.step();
    pair.world.block.v = 0;
    pair.step(500);
    ASSERT_GT(pair.force(), 3);
    ASSERT_TRUE(pair.planes->counters().live);
  }
  /// Steps, and returns the largest change of the force in a step, N.
  double largest_jump(int steps) {
    double jump = 0;
    for (int i = 0; i < steps; ++i) {
      const double before = pair.force();
      pair.step();
      jump = std::max(jump, std::abs(pair.force() - before));
    }
    return jump;
  }
  /// Sends the packet, and expects that it is refused.
  void expect_refused(const WorldPacket& packet, const char* why) {
    const std::uint64_t before = pair.planes->counters().malformed;
    pair.world.forged = packet;
    const double F = pair.force();
    pair.step();
    EXPECT_EQ(pair.planes->counters().malformed, before + 1) << why;
    EXPECT_NEAR(pair.force(), F, 0.01) << why;
  }

  Pair pair{peg(0.03, 0, 0), {.x = 0.05, .v = -0.01, .is_fixed = true}};
};

TEST_F(Pressed, ASilentWorldReleasesItsPlanesSmoothly) {
  pair.world.is_killed = true;
  EXPECT_LT(largest_jump(1000), 0.2);  // of 4 N
  EXPECT_EQ(pair.force(), 0);
  EXPECT_FALSE(pair.planes->counters().live);
  EXPECT_EQ(pair.planes->counters().silences, 1u);
  EXPECT_EQ(pair.world.tool.flags, 0u);
  pair.world.is_killed = false;  // it is restarted, and its plane is 10 mm in the tool
  EXPECT_LT(largest_jump(3000), 2);
  EXPECT_GT(pair.force(), 0.5);  // as far as the allowance reaches
  EXPECT_EQ(pair.world.tool.flags, std::uint32_t{ToolPacket::live});
  EXPECT_FALSE(any(pair.fault));
}

TEST_F(Pressed, AStifferPlaneDoesNotJump) {
  for (const double k : {4000.0, 300.0, 1000.0}) {
    pair.world.k = k;
    EXPECT_LT(largest_jump(1000), k < k_contact ? 5 : 0.6) << k;
  }
  EXPECT_FALSE(any(pair.fault));
}

TEST_F(Pressed, AbsurdPacketsAreRefusedAndCounted) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(),
                   inf = std::numeric_limits<double>::infinity();
  const auto refuse = [&](const char* why, auto&& change) {
    WorldPacket packet = pair.world.packet();
    change(packet);
    expect_refused(packet, why);
  };
  for (const double x : {nan, inf, -inf, 1e3}) {
    refuse("point", [&](WorldPacket& p) { p.planes[0].p_W_m[1] = x; });
    refuse("normal", [&](WorldPacket& p) { p.planes[0].n_W[2] = x; });
    refuse("velocity", [&](WorldPacket& p) { p.planes[0].v_W_m_s[0] = x; });
    refuse("way", [&](WorldPacket& p) { p.planes[0].moved_W_m[0] = x; });
  }
  for (const double x : {nan, inf, 0.0, -1.0, 1e9}) {
    refuse("stiffness", [&](WorldPacket& p) { p.planes[0].k_N_m = x; });
    refuse("time of use", [&](WorldPacket& p) { p.valid_s = x; });
  }
  for (const double x : {nan, inf, -1.0, 1e9})
    refuse("damping", [&](WorldPacket& p) { p.planes[0].c_Ns_m = x; });
  for (const double x : {nan, inf, 1e9}) refuse("time", [&](WorldPacket& p) { p.t_s = x; });
  for (const std::uint32_t n : {7u, 1000u, ~0u}) refuse("count", [&](WorldPacket& p) { p.num_planes = n; });
  refuse("id", [](WorldPacket& p) { p.planes[0].id = 0; });
  refuse("ids", [](WorldPacket& p) {
    p.num_planes = 2;
    p.planes[1] = p.planes[0];
  });
  refuse("magic", [](WorldPacket& p) { p.magic = 0; });
  refuse("version", [](WorldPacket& p) { p.version = 2; });
  refuse("number", [](WorldPacket& p) { p.number = 1; });
  refuse("answer", [&](WorldPacket& p) { p.answers = pair.world.tool.number + 1000; });
  WorldPacket old = pair.world.packet();
  old.t_s -= 0.2;
  pair.world.forged = old;
  pair.step();
  EXPECT_EQ(pair.planes->counters().late, 1u);
  pair.step(1000);
  EXPECT_TRUE(pair.planes->counters().live);
}

TEST_F(Pressed, TheLoopDoesNotAllocate) {
  if (!AllocationGuard::works()) GTEST_SKIP() << "a sanitizer has the heap";
  std::string calls;
  for (int i = 0; i < 100; ++i) {
    AllocationGuard guard;
    world_clock_ns += 1'000'000;
    static_cast<void>(pair.session().advance(pair.record));
    calls += guard.report();
  }
  EXPECT_THAT(calls, testing::Not(testing::ContainsRegex("alloc|free|mutex|sleep"))) << calls;
}

TEST(SlowWorld, PlanesCountOnlyForBodiesThatTouch) {
  SceneConfig scene = peg(0, 0, 0);
  EXPECT_EQ(contact_scope(scene), ContactScope::none);
  scene.world_planes = 6;
  EXPECT_EQ(contact_scope(scene), ContactScope::obstacles);
  EXPECT_EQ(contact_counts(scene).surfaces, 7u);
  scene.bodies[0].spheres.clear();
  scene.bodies[0].shapes.clear();
  EXPECT_EQ(contact_scope(scene), ContactScope::none);
}

}  // namespace
}  // namespace godobject::test_world
