// Joints of bodies with contacts, at the predicted end of a stage, about the bodies' centres of mass.
#pragma once

#include <array>

#include "core/joint/list.h"
#include "core/math/spatial.h"

namespace godobject {

/// Joint of a body at the predicted end of a stage. Undefined between steps.
struct JointEdge {
  JointKind kind{};
  std::size_t parent = world;
  Column a_W;  // anchor, on the body
  int num_turns = 0, num_axes = 0;
  std::array<Column, 3> s;                 // axes, unit: turns, then slides
  std::array<Real, 2> stop_D{}, stop_b{};  // terms of stops on the coordinates: effective mass, and impulse
                                           // at rest
  Real slide_D = 0;                        // effective mass added to the slide (40), its impulse in stop_b
  std::uint32_t stop_entry = 0;            // entry in the system of its island

  bool on_world() const noexcept { return kind != JointKind::free && parent == world; }
  bool on_body() const noexcept { return parent != world; }
  bool has_stops() const noexcept { return stop_D[0] > 0 || stop_D[1] > 0 || slide_D > 0; }
  /// Returns the effective mass on coordinate k.
  Real on_coordinate(int k) const noexcept {
    return stop_D[static_cast<std::size_t>(k)] + (k >= num_turns ? slide_D : 0);
  }
};

/// Returns the twist at p of a rotation about, or a translation along, axis k.
inline SpatialVector axis_twist(const JointEdge& edge, int k, const Column& p) noexcept {
  const Column& s = edge.s[static_cast<std::size_t>(k)];
  if (k >= edge.num_turns) return {.w = Column(Pack(0)), .v = s};
  return {.w = s, .v = cross(s, p - edge.a_W)};
}
/// Returns the wrench about p of a torque about, or a force along, axis k.
inline SpatialVector axis_wrench(const JointEdge& edge, int k, const Column& p) noexcept {
  const Column& s = edge.s[static_cast<std::size_t>(k)];
  if (k < edge.num_turns) return {.w = s, .v = Column(Pack(0))};
  return {.w = cross(edge.a_W - p, s), .v = s};
}

/// Joints of all bodies to their parents, with the motion that they transmit.
template <std::size_t N>
struct JointEdges {
  std::array<JointEdge, N> edges;
  std::array<bool, N> joined;        // true if the body is a parent or a child of a joint
  std::array<Column, N> p;           // centres of mass
  std::array<SpatialVector, N> V_p;  // twists that satisfy the joints
};

}  // namespace godobject
