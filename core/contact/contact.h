// Penalty contacts of spheres: their law, and what a scene says about them. d: depth; v: velocity of the contact point
// against the surface, n off the surface; xi: its drag since it stuck; e: the rest penetration, offset of the contact
// spring, with which bodies begin that are put into each other (e = d), and which is relaxed at the depenetration velocity.
//
//   (22)  F_n = max(k (d - e) - c v_n, 0) where d > 0
//   (23)  F_t = -(k_t xi + c_t v_t) while |F_t| <= mu F_n; beyond, the contact point slips and |F_t| = mu F_n
//
// The room: memory.h is what a contact carries over, find/ the search, candidates.h what it lists, stage.h four contacts in
// a stage, pairs.h, islands.h and jointed_bodies.h who touches whom, line_search.h and unbalanced.h Newton's method, pass_on.h its residual as forces,
// bodies.h all of a step. What contacts couple is solved in core/system.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "core/joint/joint.h"
#include "core/math/block.h"
#include "core/shape/list.h"
#include "core/tuning.h"

namespace godobject {

/// The law of a pair of materials: what one sphere's contact does. Spheres that share a load add up their stiffness.
struct ContactLaw {
  Real k = 0;            // N/m
  Real c = 0;            // N s/m
  Real mu = 0;           // Coulomb, sticking and slipping
  Real k_t = 0;          // N/m, of a contact point that sticks
  Real c_t = 0;          // N s/m; k_t and c_t are not both zero where mu is not
  Real push_out = 0.05;  // m/s, depenetration velocity: the rest penetration is relaxed at it

  bool operator==(const ContactLaw&) const = default;
};

using MaterialId = std::uint8_t;  // < max_materials

/// A sphere fixed on a body.
struct BodySphere {
  std::size_t body = 0;
  Vec3 p_B = Vec3::Zero();  // its centre from the body's centre of mass, m
  Real radius = 0;          // m, > 0
  MaterialId material = 0;
};

/// What spheres touch: an obstacle of the world, or a shape fixed on a body.
struct Surface {
  std::size_t body = world;
  ShapeParams shape;  // its X_WS is against the body if it has one
  MaterialId material = 0;
};

/// Constant while running. Spheres are in the order of their bodies; so are surfaces, those of the world first.
template <std::size_t max_spheres_, std::size_t max_surfaces_>
struct ContactParams {
  std::array<BodySphere, max_spheres_> spheres;
  std::size_t num_spheres = 0;
  std::array<Surface, max_surfaces_> surfaces;
  std::size_t num_surfaces = 0;
  std::array<std::array<ContactLaw, max_materials>, max_materials> laws;  // [a][b] is [b][a]

  const ContactLaw& law(MaterialId a, MaterialId b) const noexcept { return laws[a][b]; }
};

/// What a step says of the contacts of the scene.
struct ContactReport {
  // where the step's last stage ends
  std::size_t num_contacts = 0;  // that bear a force
  std::size_t num_near = 0;      // listed
  Real deepest = 0;              // depth of the deepest sphere, m
  // of the step's worst stage
  int newton_iterations = 0;  // Newton iterations over the contact modes, of the island that took most
  int iterations = 0;         // of conjugate gradients, in all of them, likewise
  int num_without_room = 0;   // islands whose blocks had no room: solved by these
  Real residual = 0;          // by how much the worst contact's force misses (22), (23), N
  Real residual_share = 0;    // the same as a share of the largest normal force of its island
  int num_stopped = 0;        // islands whose Newton iterations were stopped before they converged
  // of the step
  Real found =
      0;  // what contact springs were found with where stages began, beyond what they were left with, J

  /// What of it is of the step's worst stage: that of the stages before was `before`.
  void cover(const ContactReport& before) noexcept {
    newton_iterations = std::max(newton_iterations, before.newton_iterations);
    iterations = std::max(iterations, before.iterations);
    num_without_room = std::max(num_without_room, before.num_without_room);
    residual = std::max(residual, before.residual);
    residual_share = std::max(residual_share, before.residual_share);
    num_stopped = std::max(num_stopped, before.num_stopped);
  }
};

/// And of one body: the sum of its contact forces, about its centre of mass, world axes. Of Output: mean over the step.
struct ContactWrench {
  Wrench F_W;
};

}  // namespace godobject
