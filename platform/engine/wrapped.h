// Steps of a program's own, beside those of the engine: with them a program has all that `godobject run` has.
//
//   class Needle final : public WrappedEngine {
//     using WrappedEngine::WrappedEngine;
//     Wrench feedback(std::size_t i) const noexcept override { ... }
//   };
//   std::unique_ptr<Engine> with_needle(std::unique_ptr<Engine> engine, const SceneConfig&) {
//     return std::make_unique<Needle>(std::move(engine));
//   }
//   int main(int argc, char** argv) { return run_program(argc, argv, {.engine = with_needle}); }
#pragma once

#include <utility>

#include "platform/engine/engine.h"

namespace godobject {

/// Returns the engine of a scene in this program. engine: that of the scene's parts.
using EngineWrapper = std::unique_ptr<Engine> (*)(std::unique_ptr<Engine> engine, const SceneConfig& scene);

/// Makes make_engine() return wrapped engines, in runs, replays and references alike. Call it before any
/// engine is made. Null: none.
void wrap_engines(EngineWrapper wrap) noexcept;

/// An engine with the functions of another one; derived classes override those that differ. State of their
/// own belongs into state_hash(), save() and restore(), so that replays are compared and continued with it.
class WrappedEngine : public Engine {
 public:
  explicit WrappedEngine(std::unique_ptr<Engine> engine) noexcept : engine_(std::move(engine)) {}

  const Composition& composition() const noexcept override { return engine_->composition(); }
  StepReport step(std::span<const BodySample> samples) noexcept override { return engine_->step(samples); }
  void pass_time(double s) noexcept override { engine_->pass_time(s); }
  BodyView view(std::size_t i) const noexcept override { return engine_->view(i); }
  Wrench feedback(std::size_t i) const noexcept override { return engine_->feedback(i); }
  EnergyReport energy() const noexcept override { return engine_->energy(); }
  std::size_t contacts(std::span<ContactView> out) const noexcept override { return engine_->contacts(out); }
  const SceneNets& nets() const noexcept override { return engine_->nets(); }
  std::size_t net_nodes(std::span<Vec3> p_W) const noexcept override { return engine_->net_nodes(p_W); }
  double net_stretch() const noexcept override { return engine_->net_stretch(); }
  void term_forces(std::span<Wrench> F_W) const noexcept override { engine_->term_forces(F_W); }
  std::uint64_t state_hash() const noexcept override { return engine_->state_hash(); }
  std::size_t first_plane() const noexcept override { return engine_->first_plane(); }
  void set_plane(std::size_t i, const ContactPlane& plane) noexcept override { engine_->set_plane(i, plane); }
  double depth_below(const Vec3& p_W, const Vec3& n_W) const noexcept override {
    return engine_->depth_below(p_W, n_W);
  }
  std::size_t snapshot_bytes() const noexcept override { return engine_->snapshot_bytes(); }
  void save(std::span<std::byte> out) const noexcept override { engine_->save(out); }
  bool restore(std::span<const std::byte> in) noexcept override { return engine_->restore(in); }

 private:
  std::unique_ptr<Engine> engine_;
};

}  // namespace godobject
