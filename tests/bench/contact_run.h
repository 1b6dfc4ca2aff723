// A scene with contacts in the core.
#pragma once

#include <stdexcept>

#include "sim/study/case_run.h"
#include "tests/bench/bench.h"
#include "tests/bench/contact_quality.h"
#include "tests/bench/peer.h"

namespace godobject::bench {

template <Scene S>
class ContactRun {
 public:
  /// Keeps references to both. Throws std::invalid_argument for parameters that validate() refuses.
  ContactRun(const ContactScene& scene, const Targets& targets) : scene_(scene), targets_(targets) {
    par_.h = h;
    par_.num_bodies = scene.problem.bodies.size();
    par_.gravity_W = scene.problem.gravity;
    for (std::size_t i = 0; i < par_.num_bodies; ++i) {
      const oracle::Body& body = scene.problem.bodies[i];
      par_.bodies[i].body = rigid_body(body.m, body.I_B);
      par_.bodies[i].device.rise = 0;
      in_.devices[i].engaged = body.coupling.has_value();
    }
    const oracle::Coupling& c = scene.coupling();
    par_.bodies[0].coupling = {.k = c.k_t, .g = c.g_t, .k_r = c.k_r, .g_r = c.g_r};
    set_contacts();
    if (validate(par_) != Invalid::nothing) throw std::invalid_argument(scene.name + ": invalid parameters");
    restart();
  }

  void restart() {
    x_ = State<S>{};
    for (std::size_t i = 0; i < par_.num_bodies; ++i) {
      const oracle::RigidState& start = scene_.problem.bodies[i].start;
      place(x_, i, {.X_WB = {.p = start.p, .q = Quat(start.q)}, .V_WB = {}});
    }
    engage_at(x_, 0, study::target_of(targets_.front().front()));
  }

  void step(std::size_t n) noexcept {
    const oracle::RigidState& D = targets_[n + 1].front();
    study::set_input(D, D, in_.devices[0]);
    godobject::step(par_, in_, x_, w_, out_);
  }

  /// Throws std::runtime_error for a fault of the last step.
  Snapshot snapshot() const {
    if (any(out_.fault)) throw std::runtime_error(scene_.name + ": the step reported a fault");
    Snapshot now;
    now.num_contacts = out_.contacts.num_contacts;
    for (std::size_t i = 0; i < par_.num_bodies; ++i) {
      const BodyOutput<S>& body = out_.bodies[i];
      oracle::RigidState& x = now.bodies.emplace_back();
      x.p = body.X_WB.p;
      x.q = oracle::Quaterniond(body.X_WB.q);
      x.v = body.V_WB.v;
      x.w = body.V_WB.w;
    }
    return now;
  }

 private:
  void set_contacts() {
    auto& contacts = par_.contacts;
    contacts.laws[0][0] = scene_.law;
    contacts.surfaces[contacts.num_surfaces++] = {};  // the plane z = 0
    for (std::size_t i = 0; i < par_.num_bodies; ++i) {
      for (const Vec3& p_B : scene_.centres)
        contacts.spheres[contacts.num_spheres++] = {.body = i, .p_B = p_B, .radius = scene_.radius};
      if (!scene_.half_extents) continue;
      contacts.surfaces[contacts.num_surfaces++] = {
          .body = i, .shape = {.kind = ShapeKind::box, .half_extents = *scene_.half_extents}};
    }
  }

  const ContactScene& scene_;
  const Targets& targets_;
  Params<S> par_;
  Input<S> in_;
  State<S> x_;
  Scratch<S> w_;
  Output<S> out_;
};

}  // namespace godobject::bench
