// The program godobject with a guide for the hand: a spring draws it to the plane y = 0, beside all that the scene
// displays. Scenes, traces, records, the view, real buses and replays are those of `godobject`:
//
//     guided run SCENE --fast --trace trace.csv --record run.godo
//     guided replay run.godo
#include <algorithm>
#include <memory>
#include <utility>

#include "platform/cli/program.h"
#include "platform/engine/wrapped.h"
#include "platform/simulated/session.h"

using namespace godobject;

class Guided final : public WrappedEngine {
 public:
  using WrappedEngine::WrappedEngine;

  // On the real-time thread, once a step: no allocation, no wait, no output.
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
  wrap_engines([](std::unique_ptr<Engine> engine, const SceneConfig&) -> std::unique_ptr<Engine> {
    return std::make_unique<Guided>(std::move(engine));
  });
  return run_program(argc, argv, {.devices = simulated_devices(), .add_verb = add_simulate});
}
