// The program godobject with parts of its own: a hand, a law of force and, in its scene file, a mesh. All verbs of
// `godobject` are its own, with traces, records, reports, the view and the supervision of the device:
//
//     guided run scene.toml --view --trace trace.csv --record run.godo --report report.json
//     guided replay run.godo
#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "platform/cli/program.h"
#include "platform/simulated/session.h"

using namespace godobject;

// The hand. A real one copies the newest sample of its driver in read(), and gives it the wrench in command(). Both are
// called on the real-time thread, once a period: no allocation, no wait, no output.
class OwnHand final : public HandDevice {
 public:
  explicit OwnHand(const SceneConfig& scene)
      : body_(driven_bodies(scene).front()), start_(scene.bodies[body_].X_WB) {}

  void read(Period& period, std::span<BodySample> samples) noexcept override {
    const double down = std::min(period.t, 1.0), along = std::sin(period.t);
    const Pose moved{.p = Vec3(0.05 * along, 0.01, -0.05 * down), .q = Quat::Identity()};
    samples[body_].target = {.X_WD = start_ * moved,
                             .V_WD = {.v = Vec3(0.05 * std::cos(period.t), 0, down < 1 ? -0.05 : 0)}};
  }
  void command(Period&, std::span<const Wrench> F_hand_W, Shown&) noexcept override {
    wish_ = F_hand_W[body_];
  }

  // The supervisor of a run asks for these: torque runs down before the device is switched off.
  bool makes_torque() const noexcept override { return true; }
  bool run_down(Period&) noexcept override {
    wish_.f *= 0.99;
    wish_.tau *= 0.99;
    return wish_.f.norm() > 0.01;  // N
  }
  void stop(Period&) noexcept override { wish_ = {}; }

 private:
  std::size_t body_;
  Pose start_;
  Wrench wish_;  // for the drives
};

// The step: a spring draws the hand to the plane y = 0, beside all that the scene displays.
class Guided final : public WrappedEngine {
 public:
  using WrappedEngine::WrappedEngine;

  StepReport step(std::span<const BodySample> samples) noexcept override {
    const BodySample& hand = samples[0];
    const bool is_live = hand.valid && hand.engaged;
    force_N_ = is_live ? std::clamp(-stiffness * hand.target.X_WD.p.y(), -most_N, most_N) : 0;
    return WrappedEngine::step(samples);
  }
  // The wrench on the hand, for its drives and limits ...
  Wrench feedback(std::size_t i) const noexcept override {
    Wrench F = WrappedEngine::feedback(i);
    if (i == 0) F.f.y() += force_N_;
    return F;
  }
  // ... and for traces and the view.
  BodyView view(std::size_t i) const noexcept override {
    BodyView body = WrappedEngine::view(i);
    if (i == 0) body.feedback_D.f.y() += force_N_;
    return body;
  }

 private:
  static constexpr double stiffness = 100, most_N = 3;  // N/m, N
  double force_N_ = 0;
};

int main(int argc, char** argv) {
  return run_program(
      argc, argv,
      {.simulated = simulated_devices(),
       .add_verb = add_simulate,
       .engine = [](std::unique_ptr<Engine> engine, const SceneConfig&) -> std::unique_ptr<Engine> {
         return std::make_unique<Guided>(std::move(engine));
       },
       .device = [](const SceneConfig& scene, std::string&) -> std::unique_ptr<HandDevice> {
         return std::make_unique<OwnHand>(scene);
       }});
}
