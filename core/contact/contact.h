// Contacts of spheres: parameters and report.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "core/body/rigid_body.h"
#include "core/contact/law.h"
#include "core/math/block.h"
#include "core/shape/list.h"
#include "core/tuning.h"

namespace godobject {

using MaterialId = std::uint8_t;  // < max_materials

/// A sphere fixed on a body.
struct BodySphere {
  std::size_t body = 0;
  Vec3 p_B = Vec3::Zero();  // centre from the body's centre of mass, m
  Real radius = 0;          // m, > 0
  MaterialId material = 0;
};

/// Surface touched by spheres: an obstacle of the world, or a shape fixed on a body.
struct Surface {
  std::size_t body = world;
  ShapeParams shape;  // X_WS: pose on the body, or in the world without a body
  MaterialId material = 0;
  // bit j is set if a sphere of its body rounds its point j (core/shape/points.h) and touches instead of it
  std::uint8_t rounded = 0;
};

/// Parameters, constant during a run. Spheres are in the order of their bodies; so are surfaces, those of the
/// world first.
template <std::size_t max_spheres_, std::size_t max_surfaces_>
struct ContactParams {
  std::array<BodySphere, max_spheres_> spheres;
  std::size_t num_spheres = 0;
  std::array<Surface, max_surfaces_> surfaces;
  std::size_t num_surfaces = 0;
  std::array<std::array<ContactLaw, max_materials>, max_materials> laws;  // symmetric: [a][b] is [b][a]

  const ContactLaw& law(MaterialId a, MaterialId b) const noexcept { return laws[a][b]; }
  /// Returns the material of a touched element: a surface, or a sphere numbered after them.
  MaterialId material_of(std::uint32_t touched) const noexcept {
    return touched < max_surfaces_ ? surfaces[touched].material : spheres[touched - max_surfaces_].material;
  }
};

/// Report of a step on the contacts of the scene.
struct ContactReport {
  // values at the end of the step's last stage
  std::size_t num_contacts = 0;  // active contacts
  std::size_t num_near = 0;      // near contacts
  Real deepest = 0;              // depth of the deepest sphere, m
  // values of the step's worst stage
  int newton_iterations = 0;  // Newton iterations over the contact modes, largest of any island
  int iterations = 0;         // conjugate gradient iterations in all of these Newton iterations
  int num_without_room = 0;   // islands with too few blocks, solved by conjugate gradients
  Real residual = 0;          // largest deviation of a contact force from (22), (23), N
  Real residual_share = 0;    // residual as a share of the largest normal force of its island
  int num_stopped = 0;        // islands whose Newton iterations were cut off before they converged
  // value of the whole step
  Real found =
      0;  // energy of contact springs at the start of stages in excess of that at the end of the previous
          // ones, J

  /// Combines the report with `before`, the report of the previous stages: takes the maximum of each
  /// worst-stage quantity.
  void cover(const ContactReport& before) noexcept {
    newton_iterations = std::max(newton_iterations, before.newton_iterations);
    iterations = std::max(iterations, before.iterations);
    num_without_room = std::max(num_without_room, before.num_without_room);
    residual = std::max(residual, before.residual);
    residual_share = std::max(residual_share, before.residual_share);
    num_stopped = std::max(num_stopped, before.num_stopped);
  }
};

/// Sum of the contact forces of one body, about its centre of mass, world axes. In Output: mean over the
/// step.
struct ContactWrench {
  Wrench F_W;
};

}  // namespace godobject
