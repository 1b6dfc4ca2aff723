// A box on small spheres that a spring presses against obstacles.
#pragma once

#include <limits>

#include "tests/core/contact/contact_scene.h"

namespace godobject {

/// A box with a small sphere at each corner.
struct PressedBox {
  Real m = 0.1, radius = 2e-4;
  Vec3 half = Vec3(0.02, 0.02, 0.01);
};

struct Press {
  Real h = 1e-3, k = 1e6, zeta = 1.4, mu = 0.3;  // the ratio is about the mass of the body
  Real k_coupling = 1e3;
  Vec3 target = Vec3(0, 0, -0.05);
};

template <class I>
using Pressed = Touching<I, 1, 12>;

template <class I>
std::unique_ptr<Running<Pressed<I>>> pressed(const PressedBox& box, const Press& press, const Pose& start) {
  auto run = std::make_unique<Running<Pressed<I>>>();
  auto& par = run->par;
  par.h = press.h;
  const Vec3 sq = box.half.cwiseProduct(box.half);
  const Vec3 I_B = box.m / 3 * Vec3(sq.y() + sq.z(), sq.z() + sq.x(), sq.x() + sq.y());
  par.bodies[0].body = rigid_body(box.m, I_B.asDiagonal());
  const Real k = press.k_coupling, k_r = 1e-3 * k;
  par.bodies[0].coupling = {.k = k,
                            .g = Real(2.8) * std::sqrt(k * box.m),
                            .k_r = k_r,
                            .g_r = Real(2.8) * std::sqrt(k_r * I_B.maxCoeff())};
  const Vec3 at = box.half - Vec3::Constant(box.radius);
  for (int i = 0; i < 8; ++i)
    add_sphere(par, 0, Vec3(i & 4 ? at.x() : -at.x(), i & 2 ? at.y() : -at.y(), i & 1 ? at.z() : -at.z()),
               box.radius);
  const Real c = 2 * press.zeta * std::sqrt(box.m * press.k);
  set_law(par, {.k = press.k, .c = c, .mu = press.mu, .k_t = press.k, .c_t = c});
  place(run->x, 0, {.X_WB = start, .V_WB = {}});
  hold_at(*run, {.p = press.target, .q = Quat::Identity()});
  return run;
}

/// The fastest that a point of the body moves over a number of steps, m/s; infinite for a fault.
template <class S>
Real fastest(Running<S>& run, int steps, Real lever) {
  Real most = 0;
  for (int i = 0; i < steps; ++i) {
    run.step();
    if (any(run.out.fault)) return std::numeric_limits<Real>::infinity();
    const RigidBodyState& x = run.x.bodies[0].x;
    most = std::max(most, x.v_W.norm() + lever * x.w_B.norm());
  }
  return most;
}

}  // namespace godobject
