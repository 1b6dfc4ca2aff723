// A program's own step around the engine: in sessions, their references and replays.
#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "platform/engine/wrapped.h"
#include "platform/scene/toml.h"
#include "platform/simulated/session.h"
#include "tests/support/desk_scene.h"

namespace godobject {
namespace {

constexpr double own_N = 0.25;

/// Adds a force along y to the displayed wrench of the first body, and counts its steps.
class Pushing final : public WrappedEngine {
 public:
  using WrappedEngine::WrappedEngine;
  StepReport step(std::span<const BodySample> samples) noexcept override {
    ++num_steps;
    return WrappedEngine::step(samples);
  }
  Wrench feedback(std::size_t i) const noexcept override {
    Wrench F = WrappedEngine::feedback(i);
    F.f.y() += own_N;
    return F;
  }
  BodyView view(std::size_t i) const noexcept override {
    BodyView body = WrappedEngine::view(i);
    body.feedback_D.f.y() += own_N;
    return body;
  }
  static inline int num_steps = 0;
};

class Wrapped : public testing::Test {
 protected:
  ~Wrapped() override { wrap_engines(nullptr); }

  static CycleRecord after(int steps, BusChoice bus) {
    const SceneConfig scene = parse_scene(test::desk_scene("stiffness = 20\n"), "desk.toml").scene.value();
    const Session::Made made = make_session(scene, Motion(scene), bus);
    EXPECT_TRUE(made.session && made.session->boot(5));
    CycleRecord record = made.session->at_start();
    made.session->list_inputs();
    for (int k = 0; k < steps; ++k) made.session->cycle(record);
    return record;
  }
};

TEST_F(Wrapped, ItsForceIsDisplayedAndRecorded) {
  const CycleRecord plain = after(50, BusChoice::direct);
  wrap_engines([](std::unique_ptr<Engine> engine, const SceneConfig&) -> std::unique_ptr<Engine> {
    return std::make_unique<Pushing>(std::move(engine));
  });
  Pushing::num_steps = 0;
  const CycleRecord own = after(50, BusChoice::direct);
  EXPECT_EQ(Pushing::num_steps, 50);
  EXPECT_EQ(own.bodies[0].feedback_D.f.y(), plain.bodies[0].feedback_D.f.y() + own_N);
  EXPECT_EQ(own.bodies[0].feedback_D.f.x(), plain.bodies[0].feedback_D.f.x());
  EXPECT_EQ(own.bodies[0].X_WB.p, plain.bodies[0].X_WB.p);
}

TEST_F(Wrapped, ItsForceReachesTheDrives) {
  const double plain = after(200, BusChoice::sim).drive_torque[1];
  wrap_engines([](std::unique_ptr<Engine> engine, const SceneConfig&) -> std::unique_ptr<Engine> {
    return std::make_unique<Pushing>(std::move(engine));
  });
  constexpr double metres_per_rad = 0.02;  // of desk_scene(); torques are sent in per mille of 1 N m
  EXPECT_NEAR(after(200, BusChoice::sim).drive_torque[1] - plain, own_N * metres_per_rad, 2e-3);
}

TEST_F(Wrapped, WithoutAWrapperEnginesAreThoseOfTheScene) {
  const CycleRecord a = after(20, BusChoice::direct), b = after(20, BusChoice::direct);
  EXPECT_EQ(a.state_hash, b.state_hash);
  EXPECT_EQ(a.bodies[0].feedback_D.f, b.bodies[0].feedback_D.f);
}

}  // namespace
}  // namespace godobject
