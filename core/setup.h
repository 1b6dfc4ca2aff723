// Setup before the first step: derived constants, checks of the parameters, the initial state.
#pragma once

#include <Eigen/Eigenvalues>

#include "core/contact/contact.h"
#include "core/device/device.h"
#include "core/device/feedback.h"
#include "core/joint_stage.h"
#include "core/net/setup.h"
#include "core/validity.h"

namespace godobject {

/// Returns the principal moments of inertia, ascending, kg m^2.
inline Vec3 principal_moments(const Mat3& I_B) noexcept {
  return Eigen::SelfAdjointEigenSolver<Mat3>(I_B, Eigen::EigenvaluesOnly).eigenvalues();
}

/// Returns the bound c of |w'| <= c |w| |w| in the energy norm w.I w, for a free body, I w' = I w x w. In
/// principal axes w_i' = (I_j - I_k) / I_i w_j w_k. Physical bodies obey I_i <= I_j + I_k and have c = 1.
inline Real nutation(const Vec3& moments) noexcept {
  Real rate = 1;
  for (int i = 0; i < 3; ++i) {
    const Real I_j = moments[(i + 1) % 3], I_k = moments[(i + 2) % 3];
    rate = std::max(rate, std::abs(I_j - I_k) / std::sqrt(moments[i] * std::max(I_j, I_k)));
  }
  return rate;
}

/// Returns the parameters of a body with all constants derived from mass and inertia.
inline RigidBodyParams rigid_body(Real m, const Mat3& I_B) noexcept {
  const Vec3 moments = principal_moments(I_B);
  const Real anisotropy = std::sqrt(moments.z() / moments.x());
  // a nearly isotropic body may turn farther
  const Real max_turn = std::max(max_extrapolated_turn / nutation(moments), max_swing / anisotropy);
  return {.m = m, .I_B = I_B, .anisotropy = anisotropy, .max_turn = max_turn};
}

inline bool is_gain(Real a) noexcept { return a >= 0 && a - a == 0; }
template <int slot>
bool is_valid(const Absent<slot>&) noexcept {
  return true;
}
inline bool is_valid(const RampParams& par) noexcept {
  return is_gain(par.rise) && is_gain(par.lost) && is_gain(par.stale);
}
inline bool is_valid(const RelativeDevice::Params& par) noexcept {
  return is_valid(static_cast<const RampParams&>(par)) && is_gain(par.display_ratio);
}
inline bool is_valid(const SpringParams& par) noexcept {
  return is_gain(par.k) && is_gain(par.g) && is_gain(par.k_r) && is_gain(par.g_r);
}
inline bool is_valid(const FeedbackParams& par) noexcept {
  return is_valid(par.gains) && is_gain(par.max_force) && is_gain(par.max_torque) &&
         is_gain(par.max_force_rate) && is_gain(par.max_torque_rate);
}

inline bool is_valid(const JointFrame& X) noexcept {
  const Real off = (X.R.transpose() * X.R - Mat3::Identity()).norm() + std::abs(X.R.determinant() - 1);
  return off <= input_tolerance && X.p.sum() - X.p.sum() == 0;
}
inline bool is_valid(const StopParams& par) noexcept {
  constexpr Real open = std::numeric_limits<Real>::infinity();
  const bool none = par.lower == -open && par.upper == open;
  return none || (par.lower <= par.upper && is_gain(par.k) && is_gain(par.g) && par.width > 0);
}

/// Validates the joint of body i.
template <class Joints>
Invalid validate_joint(const typename Joints::Params& par, std::size_t i) noexcept {
  if (par.kind == JointKind::free) return Invalid::nothing;
  if (par.parent != world && par.parent >= i) return Invalid::parent_not_before;
  if (!is_valid(par.P) || !is_valid(par.C)) return Invalid::joint_frame;
  bool coordinates = false;
  with_joint(par.kind, [&](auto kind) {
    coordinates = requires { kind.coordinates(JointFrames{}); };
  });
  if constexpr (uses<typename Joints::Stops>) {
    for (int c = 0; coordinates && c < 2; ++c)
      if (!is_valid(par.stop.stops[static_cast<std::size_t>(c)])) return Invalid::stop;
  }
  if constexpr (uses<typename Joints::Prescribed>) {
    if (par.motion.prescribed && !coordinates) return Invalid::not_imposable;
  }
  return Invalid::nothing;
}

/// Validates the contacts of bodies numbered below num_bodies. exists(i): true if i is the number of a body
/// or node.
template <std::size_t max_spheres, std::size_t max_surfaces, class Exists>
Validity validate_contacts(const ContactParams<max_spheres, max_surfaces>& par, std::size_t num_bodies,
                           Exists exists) noexcept {
  if (par.num_spheres > max_spheres) return Invalid::contact_sphere;
  if (par.num_surfaces > max_surfaces) return Invalid::contact_surface;
  std::size_t body = 0;
  for (std::size_t s = 0; s < par.num_spheres; ++s) {
    const BodySphere& sphere = par.spheres[s];
    const bool placed = is_dimension(sphere.radius) && sphere.p_B.sum() - sphere.p_B.sum() == 0;
    if (!placed || !exists(sphere.body) || sphere.body < body || sphere.material >= max_materials)
      return {Invalid::contact_sphere, s};
    body = sphere.body;
  }
  body = world;
  for (std::size_t o = 0; o < par.num_surfaces; ++o) {
    const Surface& surface = par.surfaces[o];
    const bool in_order = body == world || (surface.body != world && surface.body >= body);
    const bool owned = surface.body == world || (surface.body < num_bodies && is_carried(surface.shape.kind));
    if (!is_valid(surface.shape) || !in_order || !owned || surface.material >= max_materials)
      return {Invalid::contact_surface, o};
    body = surface.body;
  }
  for (std::size_t a = 0; a < max_materials; ++a)
    for (std::size_t b = 0; b <= a; ++b)
      if (!is_valid(par.laws[a][b]) || par.laws[a][b] != par.laws[b][a]) return Invalid::contact_law;
  return Invalid::nothing;
}

/// Bodies and joints of a scene, for the validation of its terms.
template <Scene S>
struct TermValidation {
  const Params<S>& par;

  /// True if i is the number of a body.
  bool exists(std::size_t i) const noexcept { return i < par.num_bodies; }
  /// True if body i has a joint with a coordinate c.
  bool has_coordinate(std::size_t i, int c) const noexcept {
    bool has = false;
    if constexpr (uses<typename S::Joints>) {
      if (i >= par.num_bodies) return false;
      with_joint(par.bodies[i].joint.kind, [&](auto kind) noexcept {
        const NumAxes n = num_axes(par.bodies[i].joint.kind);
        has = requires { kind.coordinates(JointFrames{}); }
        &&c >= 0 && c < n.turns + n.slides;
      });
    }
    return has;
  }
  static bool is_frame(const JointFrame& X) noexcept { return is_valid(X); }
};

/// True if all terms are valid.
template <class... Terms, class OfScene>
bool are_valid(const std::tuple<Terms...>& par, const OfScene& scene) noexcept {
  const auto valid = [&](const auto& terms) noexcept {
    bool all = terms.size <= terms.list.size();
    for (std::size_t t = 0; all && t < terms.size; ++t) all = is_valid(terms.list[t], scene);
    return all;
  };
  return std::apply([&](const auto&... terms) noexcept { return (valid(terms) && ...); }, par);
}

/// Returns the first rule that the parameters break, with the body, sphere or surface that breaks it.
template <Scene S>
Validity validate(const Params<S>& par) noexcept {
  if (!(par.h > 0 && par.h - par.h == 0)) return Invalid::step_not_positive;
  if (const Real g = par.gravity_W.sum(); g - g != 0) return Invalid::gravity;
  if (par.num_bodies < 1 || par.num_bodies > S::max_bodies) return Invalid::too_many_bodies;
  for (std::size_t i = 0; i < num_bodies(par); ++i) {
    const BodyParams<S>& b = par.bodies[i];
    const Mat3& I = b.body.I_B;
    if (!(b.body.m > 0 && b.body.m - b.body.m == 0)) return {Invalid::mass_not_positive, i};
    if (!((I - I.transpose()).norm() <= input_tolerance * I.norm() && principal_moments(I).x() > 0))
      return {Invalid::inertia_not_positive, i};
    const Vec3 moments = principal_moments(I);
    if (!(b.body.anisotropy * b.body.anisotropy * moments.x() >= (1 - rounding_tolerance) * moments.z()))
      return {Invalid::anisotropy_too_small, i};
    if (!is_valid(b.coupling) || !is_valid(b.feedback) || !is_valid(b.device))
      return {Invalid::gain_negative, i};
    if constexpr (uses<typename S::Joints>) {
      const Invalid joint = validate_joint<typename S::Joints>(b.joint, i);
      if (joint != Invalid::nothing) return {joint, i};
    }
  }
  if constexpr (uses<ContactsOf<S>>) {
    const TermValidation<S> scene{par};
    const auto exists = [&](std::size_t i) noexcept { return scene.exists(i); };
    if constexpr (uses<NetOf<S>>) {
      if (!is_valid_net(par.net, par.num_bodies)) return Invalid::net;
      if (!are_valid_attachments(par.net, par.num_bodies)) return Invalid::net_attachment;
    }
    if constexpr (uses<TermsOf<S>>)
      if (!are_valid(par.terms.of_kinds, scene)) return Invalid::term;
    return validate_contacts(par.contacts, par.num_bodies, exists);
  }
  return Invalid::nothing;
}

/// Initial state: placed bodies, at rest or moving, and released devices.
struct Start {
  Pose X_WB;
  Twist V_WB;
};

template <Scene S>
void place(State<S>& x, std::size_t i, const Start& start) noexcept {
  RigidBodyState& body = x.bodies[i].x;
  body.X_WB = {.p = start.X_WB.p, .q = start.X_WB.q.normalized()};
  body.v_W = start.V_WB.v;
  body.w_B = to_body(body.X_WB.q, start.V_WB.w);
  if constexpr (uses<typename S::Device>) x.bodies[i].device.last = {.X_WD = body.X_WB, .V_WD = {}};
}

/// Initialises the coordinates of all joints from the placed bodies, in the turn between their stops.
template <Scene S>
void start_turns(const Params<S>& par, State<S>& x) noexcept {
  if constexpr (counts_turns<S>) {
    for (std::size_t i = 0; i < num_bodies(par); ++i) {
      const auto& joint = par.bodies[i].joint;
      with_joint(joint.kind, [&]<class Kind>(Kind) noexcept {
        if constexpr (requires(const JointFrames& X) { Kind::coordinates(X); }) {
          const JointFrames X = joint_at(joint, place_of(par, x, joint.parent), place_of(par, x, i)).X;
          JointCoordinates q = Kind::coordinates(X);
          for (int c = 0; c < num_axes(joint.kind).turns; ++c)
            q[c] = start_coordinate(joint.stop.stops[static_cast<std::size_t>(c)], q[c]);
          x.bodies[i].joint.q = q;
        }
      });
    }
  }
}

/// Starts body i engaged, with the device's sample at the start of the first step, without a ramp.
template <Scene S>
void engage_at(State<S>& x, std::size_t i, const Target& sample) noexcept {
  auto& device = x.bodies[i].device;
  device.last = sample;
  device.last.X_WD.q = sample.X_WD.q.normalized();
  device.ramp = {.s = 1, .engaged = true};
}

}  // namespace godobject
