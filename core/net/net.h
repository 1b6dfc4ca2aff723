// Nets: deformable tools and organs, the paper's mass/spring surface nets. Nodes are particles; springs with
// dampers join them. Anchors are damped springs of zero length between a node and a point of its carrier or
// of the world. The carrier is the rigid component of the net, a body like any other (the god-object).
// Attachments join nodes to other bodies.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "core/body/node.h"
#include "core/contact/contact.h"

namespace godobject {

/// A node. Nodes of one carrier are consecutive.
struct NetNode {
  Real m = 0;                // kg, > 0
  std::size_t body = world;  // carrier; world: node of the scene
  Vec3 p_B = Vec3::
      Zero();  // place of its anchor: from the carrier's centre of mass in body axes, or in the world, m
  // stiffness and damping of the anchor, N/m and N s/m; both 0: no anchor. If k is 0 for all nodes joined by
  // springs, the net floats
  Real k = 0, g = 0;
  Real radius = 0;  // radius of its contact sphere, m; 0: no contacts
  MaterialId material = 0;
};

/// Spring (36) between two nodes, i < j, with a rest length.
struct NetSpring {
  std::uint32_t i = 0, j = 0;
  Real k = 0, g = 0, l_0 = 0;  // N/m, N s/m, m
};

/// Attachment (49): damped spring of zero length between a node and a point of a body other than its carrier,
/// or of the world. A node may have several.
struct NetAttachment {
  std::uint32_t node = 0;
  std::size_t body = world;
  Vec3 p_B = Vec3::Zero();  // point on the body: from its centre of mass in body axes, or in the world, m
  Real k = 0, g = 0;        // N/m, N s/m
};
template <std::size_t max>
struct NetAttachments {
  std::array<NetAttachment, max> list;
  std::size_t size = 0;

  const NetAttachment* begin() const noexcept { return list.data(); }
  const NetAttachment* end() const noexcept { return list.data() + size; }
};
/// Empty storage of a net without attachments.
template <>
struct NetAttachments<0> {
  static constexpr std::size_t size = 0;

  static constexpr const NetAttachment* begin() noexcept { return nullptr; }
  static constexpr const NetAttachment* end() noexcept { return nullptr; }
};

/// Triangle of a net's surface, which nodes of other nets touch. Its nodes have one carrier and one row.
struct NetFace {
  std::array<std::uint32_t, 3> nodes{};
  bool touches_own = false;  // true if nodes of its own net touch it, too
};
/// Faces [first, end) of a row of nodes. In this order, halves of a range are apart in space (faces.h).
struct NetPatch {
  std::uint32_t first_node = 0, end_node = 0, first = 0, end = 0;
  bool touches_own = false;

  bool holds(std::uint32_t n) const noexcept { return first_node <= n && n < end_node; }
};
template <std::size_t max>
struct NetFaces {
  std::array<NetFace, max> list;
  std::size_t size = 0;
  std::array<NetPatch, max> patches;
  std::size_t num_patches = 0;
};
/// Empty storage of nets that do not touch each other.
template <>
struct NetFaces<0> {
  static constexpr std::size_t size = 0;
};

/// Up to four nodes of one carrier that no spring joins, processed at once, one per lane. Unused lanes repeat
/// the first node.
struct NodeGroup {
  std::array<std::uint32_t, 4> nodes{};
  std::uint32_t size = 0;
  std::uint32_t first = 0, end = 0;  // its slots
};

/// Up to four springs, one per node of the group, of which it is the first end. Unused lanes hold no_spring,
/// from the node to itself.
struct SpringSlot {
  std::array<std::uint32_t, 4> springs{}, others{};
};

/// Place of a node in the groups.
struct NodePlace {
  std::uint32_t group = 0, lane = 0;
};

/// Nodes [first, end) that no spring joins to other nodes. The row floats if none of its anchors has
/// stiffness: its anchor dampers then act on the deviation from its rigid motion (57).
struct NodeRow {
  std::uint32_t first = 0, end = 0;

  bool holds(std::uint32_t n) const noexcept { return first <= n && n < end; }
};

/// Parameters, constant during a run. Springs are sorted by i, then j; attachments by their nodes.
/// put_in_order() of setup.h assigns nodes to groups.
template <std::size_t max_nodes, std::size_t max_springs, std::size_t max_attachments = 0,
          std::size_t max_faces = 0>
struct NetParams {
  static constexpr std::uint32_t no_spring = max_springs;
  std::array<NetNode, max_nodes> nodes;
  std::size_t num_nodes = 0;
  std::array<NetSpring, max_springs + 1> springs;  // the springs and no_spring, which has no stiffness
  std::size_t num_springs = 0;
  [[no_unique_address]] NetAttachments<max_attachments> attachments;
  [[no_unique_address]] NetFaces<max_faces> faces;
  // in an elimination order: each node after those that springs join to it from below
  std::array<NodeGroup, max_nodes> groups;
  std::size_t num_groups = 0;
  std::array<SpringSlot, max_springs> slots;
  std::array<NodePlace, max_nodes> places;      // place of each node in the groups
  std::array<NodeRow, max_nodes / 2 + 1> rows;  // rows of two or more nodes
  std::size_t num_rows = 0;
  int max_iterations = 12;  // limit of conjugate gradient iterations in a stage
  // m/s^3: the iteration ends if no velocity changes by more than this times h^2, h of the stage. Residuals
  // add up over the steps, so they decrease like the integrator's error.
  Real tolerance = 100;

  /// Returns the tolerance in a stage of length h, m/s.
  Real tolerated_change(Real h) const noexcept { return tolerance * h * h; }
};

/// Report of a step on its nets.
struct NetReport {
  // values of the step's worst stage
  int iterations = 0;         // conjugate gradient iterations
  int newton_iterations = 0;  // Newton iterations over the contact modes
  Real residual = 0;          // largest unbalanced force on a node, N
  bool is_stopped = false;    // true if the iteration was cut off before its tolerance
  // values of the step's last stage
  bool majorised = false;        // true if springs were majorised (47)
  std::size_t num_contacts = 0;  // active contacts of nodes
  std::size_t num_near = 0;      // near contacts of nodes
  Real deepest = 0;              // depth of the deepest node, m

  void cover(const NetReport& before) noexcept {
    iterations = std::max(iterations, before.iterations);
    newton_iterations = std::max(newton_iterations, before.newton_iterations);
    residual = std::max(residual, before.residual);
    is_stopped = is_stopped || before.is_stopped;
  }
};

/// Net part of a scene: all of its nets. Capacities: nodes, springs, contacts of nodes at a time,
/// attachments, faces that nodes of nets touch.
template <std::size_t nodes_, std::size_t springs_, std::size_t contacts_, std::size_t attachments_ = 0,
          std::size_t faces_ = 0>
struct MassSpringNet {
  static constexpr std::size_t max_nodes = nodes_, max_springs = springs_, max_contacts = contacts_,
                               max_attachments = attachments_, max_faces = faces_;
  using Params = NetParams<nodes_, springs_, attachments_, faces_>;
  using Output = NetReport;
};

/// Number of a node of a net. A type of its own, because bodies have numbers, too.
struct NetNodeNumber {
  std::uint32_t n = 0;
};

}  // namespace godobject
