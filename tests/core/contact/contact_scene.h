// Bodies with spheres that touch the world: their scene, and the energy in their contacts.
#pragma once

#include <memory>

#include "core/contact/rounded.h"
#include "tests/core/one_body.h"
#include "tests/study/joint/tool.h"

namespace godobject {

/// `spheres` in all, each of which may touch two of `surfaces` at a time.
template <class I, std::size_t bodies, std::size_t spheres, class DevicePart = PoseDevice,
          std::size_t surfaces = 2, std::size_t contacts = 2 * spheres>
struct Touching {
  static constexpr std::size_t max_bodies = bodies;
  using Integrator = I;
  using Device = DevicePart;
  using Joints = TreeJoints<>;
  using Coupling = DampedSpring;
  using Feedback = None;
  using Contacts = FixedContacts<spheres, surfaces, contacts>;
};

template <Scene S>
void add_sphere(Params<S>& par, std::size_t body, const Vec3& p_B, Real radius, MaterialId material = 0) {
  par.contacts.spheres.at(par.contacts.num_spheres++) = {
      .body = body, .p_B = p_B, .radius = radius, .material = material};
}

/// Half-space below the plane z = 0 of X_WS.
template <Scene S>
void add_plane(Params<S>& par, const Pose& X_WS = {}, MaterialId material = 0) {
  par.contacts.surfaces.at(par.contacts.num_surfaces++) = {.shape = {.X_WS = X_WS}, .material = material};
}

template <Scene S>
void add_box(Params<S>& par, const Pose& X_WS, const Vec3& half_extents) {
  par.contacts.surfaces.at(par.contacts.num_surfaces++) = {
      .shape = {.kind = ShapeKind::box, .X_WS = X_WS, .half_extents = half_extents}};
}

/// Sets the law of materials a and b, and of b and a.
template <Scene S>
void set_law(Params<S>& par, const ContactLaw& law, MaterialId a = 0, MaterialId b = 0) {
  par.contacts.laws[a][b] = par.contacts.laws[b][a] = law;
}

/// Number of the surface that a contact with a sphere is on.
inline std::uint32_t touched_of(std::uint64_t key) { return static_cast<std::uint32_t>(key >> 15) & 0x7fff; }

/// In the springs of the contacts, normal and tangential.
template <Scene S>
Real contact_energy(const Params<S>& par, const State<S>& x) {
  Real E = 0;
  for (std::size_t i = 0; i < x.contacts.size; ++i) {
    const ContactMemory& m = x.contacts.list[i];
    const BodySphere& sphere = par.contacts.spheres[sphere_of(m.key)];
    const Surface& surface = par.contacts.surfaces[touched_of(m.key)];
    const ContactLaw& law = par.contacts.law(sphere.material, surface.material);
    const Pose& X = x.bodies[sphere.body].x.X_WB;
    const Real depth = sphere.radius - nearest(surface.shape, X.p + X.q * sphere.p_B, sphere.radius).distance;
    const Real compressed = std::max(depth - m.e, Real(0));
    E += Real(0.5) * (law.k * compressed * compressed + law.k_t * dot(m.xi_a, m.xi_a));
  }
  return E;
}

/// Kinetic, of the coupling, of gravity and of the contacts.
template <Scene S>
Real total_energy(const Params<S>& par, const State<S>& x) {
  return energy(par, x) + contact_energy(par, x);
}

/// The target of body 0 at rest, engaged from the first step.
template <Scene S>
void hold_at(Running<S>& run, const Pose& X_WD) {
  engage_at(run.x, 0, Target{.X_WD = X_WD, .V_WD = {}});
  run.in.devices[0].target.X_WD = X_WD;
  run.in.devices[0].target.V_WD = {};
}

}  // namespace godobject
