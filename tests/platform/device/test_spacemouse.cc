// A SpaceMouse as the device: its deflection sets the velocity of the target, within limits. Silence at rest
// is rest; silence while deflected is a lost hand.
#include "platform/device/spacemouse.h"

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <random>

#include "core/math/rotation_error.h"
#include "platform/scene/toml.h"
#include "platform/simulated/session.h"
#include "tests/support/allocation_guard.h"

namespace godobject::test_spacemouse {
namespace {

constexpr Nanoseconds ms = 1'000'000;
Nanoseconds now_ns = 0;

SceneConfig mouse_scene() {
  LoadResult loaded = load_scene(GODOBJECT_SOURCE_DIR "/sim/scenes/spacemouse.toml");
  SceneConfig scene = *loaded.scene;
  scene.obstacles.clear();
  lead_by_spacemouse(scene);
  return scene;
}

/// A session with a SpaceMouse as its device, and a clock of the test's own.
class MouseRun {
 public:
  explicit MouseRun(SceneConfig config) : scene(std::move(config)) {
    now_ns = 1'000 * ms;
    mouse.emplace(scene, []() noexcept { return now_ns; });
    made = make_session(scene, Motion(scene), BusChoice::direct);
    if (!made.session) throw std::runtime_error(made.errors.front());
    made.session->add(*mouse);
    made.session->start(1);
    record = made.session->at_start();
  }

  /// Runs periods of the loop, with the thread's ticks between them, and an event every 16 ms while `pushed`
  /// is set.
  void run(int periods, bool connected = true) {
    for (int i = 0; i < periods; ++i) {
      now_ns += ms;
      if (pushed && now_ns % (16 * ms) == 0) mouse->take(*pushed);
      if (now_ns % spacemouse_tick_ns == 0) mouse->tick(connected);
      static_cast<void>(made.session->advance(record));
      if (has(record.limited, Limited::held)) ++periods_held;
    }
  }
  const Pose& target() const { return record.bodies[0].target.X_WD; }
  void press(int button, bool down = true) {
    mouse->take({.kind = down ? SpacenavEvent::Kind::press : SpacenavEvent::Kind::release, .button = button});
  }

  SceneConfig scene;
  std::optional<SpaceMouse> mouse;
  Session::Made made;
  CycleRecord record;
  std::optional<SpacenavEvent> pushed;
  int periods_held = 0;
};

SpacenavEvent push(const Vec3& shift_W, const Vec3& turn_W = Vec3::Zero()) {
  const auto counts = [](double x) { return static_cast<std::int32_t>(x); };
  return {.axes = {counts(shift_W.x()), counts(shift_W.z()), counts(shift_W.y()), counts(turn_W.x()),
                   counts(turn_W.z()), counts(turn_W.y())}};
}

TEST(SpaceMouse, GoesAsFastAsItIsPushed) {
  std::mt19937 random(51);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int draw = 0; draw < 12; ++draw) {
    MouseRun hand(mouse_scene());
    const SpaceMouseConfig& config = *hand.scene.device->spacemouse;
    const auto drawn = [&] { return Vec3(unit(random), unit(random), unit(random)); };
    const Vec3 shift = 150 * drawn(), turn = 150 * drawn();
    hand.run(300);
    const Pose before = hand.target();
    hand.pushed = push(shift, turn);
    hand.run(800);
    hand.pushed = push(Vec3::Zero());
    hand.run(300);
    const auto speed = [&](double counts, double most) {
      const double whole = std::trunc(counts), beyond = std::max(std::abs(whole) - config.deadband, 0.0);
      return std::copysign(most * beyond / (config.full_scale - config.deadband), whole);
    };
    const Vec3 v(speed(shift.x(), config.max_speed), speed(shift.y(), config.max_speed),
                 speed(shift.z(), config.max_speed));
    const Vec3 w(speed(turn.x(), config.max_turn_rate), speed(turn.y(), config.max_turn_rate),
                 speed(turn.z(), config.max_turn_rate));
    constexpr double time = 0.8, sampling = 0.017;  // s: an event begins and ends up to its period late
    EXPECT_LT((hand.target().p - before.p - time * v).norm(), sampling * v.norm() + 1e-6);
    const Vec3 phi = to_world(before.q, rotation_error(before.q, hand.target().q, Vec3::Zero()).phi_B);
    EXPECT_LT((phi - time * w).norm(), sampling * w.norm() + 1e-6);
    EXPECT_EQ(hand.periods_held, 0);
  }
}

TEST(SpaceMouse, IsNoFasterThanAllowed) {
  MouseRun hand(mouse_scene());
  const SpaceMouseConfig& config = *hand.scene.device->spacemouse;
  hand.run(100);
  hand.pushed = push(Vec3(90'000, -90'000, 90'000), Vec3(90'000, 90'000, 90'000));
  double fastest = 0, fastest_turn = 0;
  for (int i = 0; i < 1000; ++i) {
    const Pose before = hand.target();
    hand.run(1);
    fastest = std::max(fastest, (hand.target().p - before.p).norm() / hand.scene.step);
    fastest_turn = std::max(
        fastest_turn, rotation_error(before.q, hand.target().q, Vec3::Zero()).phi_B.norm() / hand.scene.step);
  }
  EXPECT_LT(fastest, (1 + 1e-6) * config.max_speed);
  EXPECT_GT(fastest, 0.99 * config.max_speed);
  EXPECT_LT(fastest_turn, (1 + 1e-6) * config.max_turn_rate);
}

TEST(SpaceMouse, SilenceAtRestIsRest) {
  MouseRun hand(mouse_scene());
  hand.pushed = push(Vec3(0, 0, 200));
  hand.run(500);
  hand.mouse->take(push(Vec3::Zero()));
  hand.pushed.reset();
  hand.run(300);
  hand.periods_held = 0;
  const Pose before = hand.target();
  hand.run(5000);
  EXPECT_EQ(hand.periods_held, 0);
  EXPECT_LT((hand.target().p - before.p).norm(), 1e-12);
}

TEST(SpaceMouse, SilenceWhileItIsPushedIsStaleAfterThreePeriods) {
  MouseRun hand(mouse_scene());
  const SpaceMouseConfig& config = *hand.scene.device->spacemouse;
  hand.run(100);
  hand.pushed = push(Vec3(0, 0, 350));
  hand.run(500);
  ASSERT_EQ(hand.periods_held, 0);
  hand.pushed.reset();
  const Pose before = hand.target();
  hand.run(1000);
  EXPECT_GT(hand.periods_held, 850);
  EXPECT_LT((hand.target().p - before.p).norm(), config.max_speed * (3 / config.rate_hz + 0.04))
      << "it does not run away";
  hand.periods_held = 0;
  hand.pushed = push(Vec3(0, 0, 350));
  hand.run(1000);
  EXPECT_LT(hand.periods_held, 100) << "it goes on by itself";
}

TEST(SpaceMouse, WithoutItsDaemonTheTargetRests) {
  MouseRun hand(mouse_scene());
  hand.pushed = push(Vec3(0, 0, 350));
  hand.press(0);
  hand.run(300);
  hand.pushed.reset();
  hand.run(100, false);
  const Pose before = hand.target();
  hand.periods_held = 0;
  hand.run(500, false);
  EXPECT_EQ(hand.periods_held, 500);
  EXPECT_LT((hand.target().p - before.p).norm(), 1e-12);
  hand.run(500);
  hand.periods_held = 0;
  hand.pushed = push(Vec3(0, 0, 350));
  hand.run(500);
  EXPECT_EQ(hand.periods_held, 0);
  EXPECT_GT((hand.target().p - before.p).norm(), 0.03) << "the clutch is closed again, too";
}

TEST(SpaceMouse, WithItsClutchOpenMovesNothing) {
  MouseRun hand(mouse_scene());
  hand.run(100);
  hand.press(0);
  hand.run(50);
  const Pose before = hand.target();
  hand.pushed = push(Vec3(0, 300, 0));
  hand.run(500);
  EXPECT_LT((hand.target().p - before.p).norm(), 1e-12);
  hand.press(0, false);
  hand.run(500);
  EXPECT_GT(hand.target().p.y() - before.p.y(), 0.03);
}

TEST(SpaceMouse, GripsTheNearestBodyAndReleasesIt) {
  SceneConfig scene = mouse_scene();
  scene.device->grab_radius = 0.05;
  MouseRun hand(scene);
  hand.pushed = push(Vec3(0, 0, 300));
  hand.run(300);
  EXPECT_EQ(hand.record.held, std::nullopt);
  hand.press(1);
  hand.press(1, false);
  hand.run(300);
  EXPECT_EQ(hand.record.held, 0u);
  hand.run(500);
  EXPECT_GT(hand.record.bodies[0].X_WB.p.z(), 0.03) << "it is carried";
  hand.press(1);
  hand.run(20);
  EXPECT_EQ(hand.record.held, std::nullopt);
}

TEST(SpaceMouse, TurnsWithItsFrame) {
  SceneConfig scene = mouse_scene();
  scene.device->spacemouse->q_WM = Quat(std::sqrt(0.5), 0, 0, std::sqrt(0.5));  // x to the world's y
  MouseRun hand(scene);
  hand.run(100);
  hand.pushed = push(Vec3(350, 0, 0));
  hand.run(500);
  EXPECT_GT(hand.target().p.y(), 0.04);
  EXPECT_LT(std::abs(hand.target().p.x()), 1e-6);
}

TEST(SpaceMouse, TouchesNeitherHeapNorSystemInTheLoop) {
  if (!AllocationGuard::works()) GTEST_SKIP() << "the sanitizer owns the allocator";
  MouseRun hand(mouse_scene());
  hand.pushed = push(Vec3(0, 0, 300), Vec3(100, 0, 0));
  hand.run(100);
  AllocationGuard guard;
  hand.run(500);
  EXPECT_EQ(guard.calls(), 0) << guard.report();
}

TEST(SpaceMouseKeys, InvalidScenesAreReported) {
  using testing::ElementsAre, testing::HasSubstr;
  std::ifstream file(GODOBJECT_SOURCE_DIR "/sim/scenes/spacemouse.toml");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const auto errors = [&](const std::string& from, const std::string& to) {
    std::string changed = text;
    changed.replace(changed.find(from), from.size(), to);
    return parse_scene(changed, "mouse.toml").errors;
  };
  EXPECT_THAT(errors("\"relative\"", "\"impedance\""), ElementsAre(HasSubstr("displays no force")));
  EXPECT_THAT(errors("max_speed = 0.1", "deadband = 400"),
              ElementsAre(HasSubstr("must be below full_scale")));
  EXPECT_THAT(errors("max_speed = 0.1", "hold_button = 0"), ElementsAre(HasSubstr("is also clutch_button")));
  EXPECT_THAT(errors("max_speed = 0.1", "clutch_button = 300"), ElementsAre(HasSubstr("clutch_button")));
  EXPECT_THAT(errors("body = \"ball\"", "body = \"wall\""), ElementsAre(HasSubstr("wall")));
  EXPECT_THAT(errors("max_speed = 0.1", "max_speed = nan"), ElementsAre(HasSubstr("max_speed")));
  EXPECT_THAT(
      errors("phase = [-1.5707963267948966, 0.0, 0.0]", "[[motion.hold]]\ntime = 1.0\nbody = \"ball\""),
      ElementsAre(HasSubstr("requires 'grab_radius': add it")));
}

}  // namespace
}  // namespace godobject::test_spacemouse
