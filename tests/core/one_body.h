// A scene of one body made of the parts a test chooses, with all that running it needs.
#pragma once

#include <cmath>
#include <random>

#include "core/godobject.h"

namespace godobject {

template <class IntegratorPart, class DevicePart = PoseDevice, class CouplingPart = DampedSpring,
          class FeedbackPart = None>
struct OneBody {
  static constexpr int max_bodies = 1;
  using Integrator = IntegratorPart;
  using Device = DevicePart;
  using Coupling = CouplingPart;
  using Joints = None;
  using Feedback = FeedbackPart;
};

/// One running scene. Members are those of step(); `body()` and the like are short for bodies[0].
template <Scene S>
struct Running {
  Params<S> par;
  State<S> x;
  Scratch<S> w;
  Input<S> in;
  Output<S> out;

  void step() { godobject::step(par, in, x, w, out); }
  void step(int times) {
    for (int i = 0; i < times; ++i) step();
  }
  BodyParams<S>& constants() { return par.bodies[0]; }
  RigidBodyState& body() { return x.bodies[0].x; }
  auto& device() { return in.devices[0]; }
  std::uint64_t hash() const { return state_hash(par, x); }

  Real kinetic() const { return kinetic_energy(par.bodies[0].body, x.bodies[0].x); }
  /// Returns the energy of body and spring, J.
  Real energy() const { return kinetic() + coupling_at(par, x, 0).energy; }
};

inline bool is_finite(const RigidBodyState& x) {
  return x.X_WB.p.allFinite() && x.X_WB.q.coeffs().allFinite() && x.v_W.allFinite() && x.w_B.allFinite();
}
inline bool is_finite(const Wrench& F) { return F.f.allFinite() && F.tau.allFinite(); }

/// Seeded random numbers of the kinds the tests need.
class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}

  Real uniform(Real a, Real b) { return std::uniform_real_distribution<Real>(a, b)(engine_); }
  Real log_uniform(Real a, Real b) { return std::exp(uniform(std::log(a), std::log(b))); }
  Real normal() { return std::normal_distribution<Real>()(engine_); }
  int integer(int a, int b) { return std::uniform_int_distribution<int>(a, b)(engine_); }
  Vec3 vector() {
    const Real x = normal(), y = normal(), z = normal();
    return Vec3(x, y, z);
  }
  Vec3 direction() { return vector().normalized(); }
  Quat rotation() {
    const Real w = normal(), x = normal(), y = normal(), z = normal();
    return Quat(w, x, y, z).normalized();
  }
  /// Full inertia tensor with the given principal moments about random axes.
  Mat3 inertia(const Vec3& moments) {
    const Mat3 R = rotation().toRotationMatrix();
    const Mat3 I_B = R * moments.asDiagonal() * R.transpose();
    return Real(0.5) * (I_B + I_B.transpose());
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace godobject
