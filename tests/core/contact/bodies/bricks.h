// Bricks in contact with each other: solid boxes with twelve small spheres, tangent to the faces. The spheres
// are inset at the corners and in the middle of the long edges.
#pragma once

#include <gtest/gtest.h>

#include <memory>

#include "tests/core/contact/contact_scene.h"

namespace godobject {

/// Room for `spheres` on each body, a shape on each and two obstacles.
template <class I, std::size_t bodies, class DevicePart = PoseDevice, std::size_t contacts = 36 * bodies,
          std::size_t spheres = 12>
struct TouchingBodies {
  static constexpr std::size_t max_bodies = bodies;
  using Integrator = I;
  using Device = DevicePart;
  using Joints = None;
  using Coupling = DampedSpring;
  using Feedback = None;
  using Contacts = BodyContacts<spheres * bodies, bodies + 2, contacts>;
};

inline const Vec3 brick_half(0.016, 0.008, 0.005);  // m
inline constexpr Real brick_mass = 2.5e-3, corner_radius = 1.5e-3, earth_gravity = 9.81;
inline constexpr ContactLaw brick_law{.k = 2e4, .c = 6, .mu = 0.3, .k_t = 2e4, .c_t = 6};

/// Normal and tangential alike; zeta: times critical for a body of mass m on one contact.
inline ContactLaw law_of(Real k, Real zeta, Real mu = 0.3, Real m = brick_mass) {
  const Real c = zeta * 2 * std::sqrt(k * m);
  return {.k = k, .c = c, .mu = mu, .k_t = k, .c_t = c};
}

inline Pose at(const Vec3& p, const Vec3& turn = Vec3::Zero()) { return {.p = p, .q = exp_so3(turn)}; }

inline RigidBodyParams solid_box(Real m, const Vec3& half) {
  const Vec3 sq = half.cwiseAbs2();
  return rigid_body(m, Vec3(m / 3 * (Vec3::Constant(sq.sum()) - sq)).asDiagonal());
}
inline RigidBodyParams solid_ball(Real m, Real radius) {
  return rigid_body(m, Real(0.4) * m * radius * radius * Mat3::Identity());
}

/// A scene to which bodies are added; no device drives any of them before hold_at().
template <Scene S>
class Pile : public Running<S> {
 public:
  Pile() {
    this->par.num_bodies = 0;
    set_law(this->par, brick_law);
    for (auto& device : this->in.devices) device.engaged = false;
  }
  /// Returns the body's number.
  std::size_t add(const RigidBodyParams& body, const Start& start) {
    const std::size_t i = this->par.num_bodies++;
    this->par.bodies.at(i).body = body;
    this->par.bodies[i].device.rise = 0;
    place(this->x, i, start);
    return i;
  }
  std::size_t add_brick(const Start& start, Real m = brick_mass, const Vec3& half = brick_half) {
    const std::size_t i = add(solid_box(m, half), start);
    const Vec3 corner = half - Vec3::Constant(corner_radius);
    for (int k = 0; k < 12; ++k)
      add_sphere(this->par, i, corner.cwiseProduct(Vec3(k % 3 - 1, k % 6 < 3 ? -1 : 1, k < 6 ? -1 : 1)),
                 corner_radius);
    carry(i, {.kind = ShapeKind::box, .half_extents = half});
    return i;
  }
  /// A body of one sphere.
  std::size_t add_ball(const Start& start, Real m, Real radius) {
    const std::size_t i = add(solid_ball(m, radius), start);
    add_sphere(this->par, i, Vec3::Zero(), radius);
    return i;
  }
  void carry(std::size_t body, const ShapeParams& shape) {
    auto& contacts = this->par.contacts;
    Surface& surface = contacts.surfaces.at(contacts.num_surfaces++);
    surface = {.body = body, .shape = shape};
    surface.rounded = rounded_points(contacts, surface);  // by the spheres that the body has before
  }
  /// Half-space below z = 0, and gravity. Before any body carries a shape.
  void add_floor() {
    add_plane(this->par);
    this->par.gravity_W = Vec3(0, 0, -earth_gravity);
  }
  const RigidBodyState& at(std::size_t i) const { return this->x.bodies[i].x; }
  const Vec3& p(std::size_t i) const { return at(i).X_WB.p; }
  /// Returns the kinetic energy of all bodies, J.
  Real kinetic() const { return kinetic_energy(this->par, this->x); }
  /// Speed of the fastest point of any brick at most, m/s.
  Real fastest() const {
    Real most = 0;
    for (std::size_t i = 0; i < this->par.num_bodies; ++i)
      most = std::max(most, at(i).v_W.norm() + at(i).w_B.norm() * brick_half.norm());
    return most;
  }
  /// False, with a failure: a step was not taken or lost contacts.
  [[nodiscard]] bool run(Real seconds) {
    for (long n = std::lround(seconds / this->par.h); n > 0; --n) {
      this->step();
      if (!any(this->out.fault)) continue;
      ADD_FAILURE() << "fault " << static_cast<unsigned>(this->out.fault) << " at step " << this->x.tick;
      return false;
    }
    return true;
  }
  std::vector<Vec3> positions() const {
    std::vector<Vec3> all;
    for (std::size_t i = 0; i < this->par.num_bodies; ++i) all.push_back(p(i));
    return all;
  }
  /// Returns the largest motion of a body since `before`, m.
  Real drift_since(const std::vector<Vec3>& before) const {
    Real most = 0;
    for (std::size_t i = 0; i < before.size(); ++i) most = std::max(most, (p(i) - before[i]).norm());
    return most;
  }
  /// Body i by a coupling to the device's pose, from the first step on.
  void hold_at(std::size_t i, const Pose& X_WD, const SpringParams& coupling) {
    this->par.bodies[i].coupling = coupling;
    engage_at(this->x, i, Target{.X_WD = X_WD, .V_WD = {}});
    this->in.devices[i].target.X_WD = X_WD;
    this->in.devices[i].engaged = true;
  }
  /// The device of body i goes on to p within a step.
  void lead_to(std::size_t i, const Vec3& p_WD) {
    auto& device = this->in.devices[i];
    device.target.V_WD.v = (p_WD - device.target.X_WD.p) / this->par.h;
    device.target.X_WD.p = p_WD;
  }
};

}  // namespace godobject
