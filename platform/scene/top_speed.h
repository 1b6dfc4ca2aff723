// Up to which speed the contacts of a scene let nothing pass.
//
// A sphere of radius r meets a solid that is 2 T thick at its thinnest: half a box's shortest edge, the radius
// of a sphere or capsule; of a mesh at most as far as a query reaches inside; nothing limits a plane. Once its
// centre is beyond the middle, the nearest surface is the one behind, and the contact pushes it out there. So
//
//   travel:  a contact is found if the centre ends a step within (-T, r) of the surface, which steps of h v
//            cannot leave out while                                             h v < r + T
// (what is swept on its way holds above that, decision 042: spheres against obstacles, and against boxes of bodies)
//
//   energy:  the tool's m v^2 / 2 goes into one contact before its depth is r + T: v < (r + T) sqrt(k / m)
//
// Edges of boxes on two bodies cross where no sphere is, and are sought where a step is predicted to end. Spheres
// are swept, so that a box leaves another by the face through which it came in. Boxes that are T / 2 deep in each
// other along every axis have no way back. Measured, pairs are held, to the points that move fastest, while
//
//   boxes:   h v < 0.3 T,  v < (T / 2) sqrt(k / m)
//
// m: of the whole tool, and with another tool m_1 m_2 / (m_1 + m_2); k: of one sphere, damping left out. What
// goes on pushing is not in this: a hand that follows x_H deep is held as long as its coupling k_c balances the
// contact at less than r + T, x_H < (r + T) (1 + k / k_c). A body placed at its target by coupling = "imposed" is
// stopped by nothing: of it only the travel counts, and only against bodies that it can push.
//
// Shapes that meet others by the spheres of their body alone are not in it: contact/spheres_alone.h.
//
// Nodes of nets are not in it. Obstacles stop them on their way, as fast as they may be, but the carrier and the other nodes go on
// pulling by springs, and how hard depends on how far the whole net is deformed.
#pragma once

#include <optional>
#include <string>

#include "platform/scene/scene.h"

namespace godobject {

/// The speeds up to which one sphere and what it may pass, or two boxes, are held. Infinite where nothing limits them.
struct SpeedBound {
  std::string what;   // "sphere of body 'tool' and obstacle 'wall'", "boxes of bodies 'a' and 'b'"
  double travel = 0;  // m/s
  double energy = 0;  // m/s
  double hand = 0;    // x_H, m
  double top() const { return travel < energy ? travel : energy; }
};

/// Bound of the pair with the lowest top speed; none without contacts, or where nothing is promised.
std::optional<SpeedBound> top_speed(const SceneConfig& scene);

/// Subject of "... passes anything": nets and shapes that the bound leaves out are named.
const char* what_does_not_pass(const SceneConfig& scene);

/// Returns the bound in a line: "1.5 m/s: up to it nothing passes anything, ...", or that there is no limit or
/// no promise. Empty where nothing may touch.
std::string top_speed_text(const SceneConfig& scene);

/// The shortest way through the solid along inward normals, sampled at up to 2000 of its triangles, m.
double thinnest(const MeshData& mesh);

inline constexpr double advised_top_speed = 2;  // m/s: so fast is a hand

}  // namespace godobject
