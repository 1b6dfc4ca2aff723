// Speed up to which the contacts of a scene let nothing pass.
//
// A sphere of radius r touches a solid that is 2 T thick at its thinnest. T is half a box's shortest edge, or
// the radius of a sphere or capsule. For a mesh it is at most the reach of a query inside; for a plane it is
// infinite. Beyond the middle the nearest surface is the far one, where the contact pushes the sphere out. So
//
//   travel:  a contact is found if the centre ends a step within (-T, r) of the surface.
//            Steps of h v cannot skip this range if                                  h v < r + T
//   energy:  the tool's m v^2 / 2 is absorbed by one contact below the depth r + T: v < (r + T) sqrt(k / m)
//
// Swept contacts hold at higher travels too: spheres against obstacles, and against boxes of bodies (decision
// 042).
//
// Edges of boxes on two bodies cross without spheres, and are searched at the predicted end of a step.
// Spheres are swept, so that a box leaves another by its face of entry. Boxes that overlap by T / 2 along
// every axis do not separate again. In tests with v of the fastest points of the boxes, pairs hold if
//
//   boxes:   h v < 0.3 T,  v < (T / 2) sqrt(k / m)
//
// m: mass of the whole tool, with another tool m_1 m_2 / (m_1 + m_2).
// k: stiffness of one sphere's contact, without damping.
//
// A hand that keeps pushing has a bound of its own. Its target x_H deep is held if the coupling k_c balances
// the contact at less than r + T: x_H < (r + T) (1 + k / k_c). A prescribed body, placed at its target
// in every step, is stopped by nothing. Only the travel bounds it, and only against bodies that it can push.
//
// Not included: shapes that touch others only with spheres (contact/spheres_alone.h), and nodes of nets.
// Obstacles stop nodes at any speed. But the carrier and other nodes pull them on by springs, with a force
// that depends on the deformation of the whole net.
#pragma once

#include <optional>
#include <string>

#include "platform/scene/scene.h"

namespace godobject {

/// Speeds up to which a sphere and its opposite solid, or two boxes, hold. Infinite without a bound.
struct SpeedBound {
  std::string what;   // "sphere of body 'tool' and obstacle 'wall'", "boxes of bodies 'a' and 'b'"
  double travel = 0;  // m/s
  double energy = 0;  // m/s
  double hand = 0;    // x_H, m
  double top() const { return travel < energy ? travel : energy; }
};

/// Returns the bound of the pair with the lowest top speed; none without contacts, or if there is no bound.
std::optional<SpeedBound> top_speed(const SceneConfig& scene);

/// Returns the subject of "... passes through a solid", with the nets and shapes that the bound excludes.
const char* what_does_not_pass(const SceneConfig& scene);

/// Returns the bound as a line: "1.5 m/s: up to this speed nothing passes through a solid, ...", or that it
/// is infinite or missing. Empty if nothing can touch.
std::string top_speed_text(const SceneConfig& scene);

/// Returns the shortest distance through the solid along inward normals, sampled at up to 2000 triangles, m.
double thinnest(const MeshData& mesh);

inline constexpr double advised_top_speed = 2;  // m/s, speed of a fast hand

}  // namespace godobject
