// Scenes with nets: their types, and nets of a few shapes.
#pragma once

#include <functional>
#include <memory>

#include "core/energy_balance.h"
#include "tests/core/one_body.h"

namespace godobject {

template <class I, std::size_t bodies = 4, std::size_t nodes = 65, std::size_t springs = 400,
          std::size_t contacts = 256>
struct NetScene {
  static constexpr std::size_t max_bodies = bodies;
  using Integrator = I;
  using Device = PoseDevice;
  using Joints = None;
  using Coupling = DampedSpring;
  using Feedback = None;
  using Contacts = BodyContacts<4, 4, 32>;
  using Net = MassSpringNet<nodes, springs, contacts>;
};

/// With the parts of the program's scenes with nets: joints, stops, prescribed joints and feedback.
template <class I>
struct JointedNetScene : NetScene<I> {
  using Joints = TreeJoints<JointStops, PrescribedJoints>;
  using Feedback = LimitedFeedback;
};

/// With capacity for attachments.
template <class I>
struct AttachedNetScene : JointedNetScene<I> {
  using Net = MassSpringNet<65, 400, 256, 32>;
};

/// Properties of all springs and anchors of a net.
struct Stuff {
  Real m = 1e-4;          // of a node, kg
  Real k = 100, g = 0;    // N/m, N s/m
  Real k_a = 0, g_a = 0;  // of anchors
  Real radius = 0;        // of nodes, m
  std::size_t carrier = world;
};

template <class S>
std::uint32_t add_node(Params<S>& par, const Stuff& of, const Vec3& p_B) {
  par.net.nodes.at(par.net.num_nodes) = {
      .m = of.m, .body = of.carrier, .p_B = p_B, .k = of.k_a, .g = of.g_a, .radius = of.radius};
  return static_cast<std::uint32_t>(par.net.num_nodes++);
}

/// A spring as long as its nodes are apart.
template <class S>
void add_spring(Params<S>& par, const Stuff& of, std::uint32_t i, std::uint32_t j) {
  const Real l_0 = (par.net.nodes.at(i).p_B - par.net.nodes.at(j).p_B).norm();
  par.net.springs.at(par.net.num_springs++) = {.i = i, .j = j, .k = of.k, .g = of.g, .l_0 = l_0};
}

/// Attaches the node to the body where it is at the start: bodies and nodes have been placed.
template <class S>
void attach(Params<S>& par, const State<S>& x, std::uint32_t node, std::size_t body, Real k, Real g) {
  const Vec3& p_W = x.net.nodes.at(node).p_W;
  const Pose X_WB = body == world ? Pose{} : x.bodies.at(body).x.X_WB;
  auto& all = par.net.attachments;
  all.list.at(all.size++) = {
      .node = node, .body = body, .p_B = X_WB.q.conjugate() * (p_W - X_WB.p), .k = k, .g = g};
  put_in_order(par.net);
}

/// A sheet of nx x ny nodes, `a` apart, in the plane z = 0 about the origin, with both diagonals.
template <class S>
void add_sheet(Params<S>& par, const Stuff& of, std::uint32_t nx, std::uint32_t ny, Real a) {
  const auto first = static_cast<std::uint32_t>(par.net.num_nodes);
  for (std::uint32_t y = 0; y < ny; ++y)
    for (std::uint32_t x = 0; x < nx; ++x)
      add_node(par, of, a * Vec3(x - 0.5 * (nx - 1.0), y - 0.5 * (ny - 1.0), 0));
  const auto at = [&](std::uint32_t x, std::uint32_t y) { return first + y * nx + x; };
  for (std::uint32_t y = 0; y < ny; ++y) {
    for (std::uint32_t x = 0; x < nx; ++x) {
      if (x + 1 < nx) add_spring(par, of, at(x, y), at(x + 1, y));
      if (y + 1 < ny) add_spring(par, of, at(x, y), at(x, y + 1));
      if (x + 1 < nx && y + 1 < ny) add_spring(par, of, at(x, y), at(x + 1, y + 1));
      if (x > 0 && y + 1 < ny) add_spring(par, of, at(x, y), at(x - 1, y + 1));
    }
  }
  put_in_order(par.net);
}

/// Adds a tube about z of `along` rings of `round` nodes, `a` apart. Each ring is turned by half a step
/// against the previous one.
template <class S>
void add_tube(Params<S>& par, const Stuff& of, std::uint32_t round, std::uint32_t along, Real a) {
  const auto first = static_cast<std::uint32_t>(par.net.num_nodes);
  const Real radius = a / (2 * std::sin(pi / round));
  for (std::uint32_t z = 0; z < along; ++z) {
    for (std::uint32_t r = 0; r < round; ++r) {
      const Real t = 2 * pi * (r + 0.5 * (z % 2)) / round;
      add_node(par, of,
               Vec3(radius * std::cos(t), radius * std::sin(t), 0.87 * a * (z - 0.5 * (along - 1.0))));
    }
  }
  const auto at = [&](std::uint32_t r, std::uint32_t z) { return first + z * round + r % round; };
  for (std::uint32_t z = 0; z < along; ++z) {
    for (std::uint32_t r = 0; r < round; ++r) {
      add_spring(par, of, at(r, z), at(r + 1, z));
      if (z + 1 == along) continue;
      add_spring(par, of, at(r, z), at(r, z + 1));
      add_spring(par, of, at(r, z), at(r + (z % 2 == 1 ? 1 : round - 1), z + 1));
    }
  }
  put_in_order(par.net);
}

/// Adds `nodes` random nodes within a ball. Each is joined to one before it, and as many more springs join
/// any two.
template <class S>
void add_tangle(Random& random, Params<S>& par, const Stuff& of, std::uint32_t nodes, Real a) {
  const auto first = static_cast<std::uint32_t>(par.net.num_nodes);
  for (std::uint32_t n = 0; n < nodes; ++n) add_node(par, of, a * std::cbrt(nodes) * 0.5 * random.vector());
  const auto joined = [&](std::uint32_t i, std::uint32_t j) {
    for (std::size_t s = 0; s < par.net.num_springs; ++s)
      if (par.net.springs[s].i == std::min(i, j) && par.net.springs[s].j == std::max(i, j)) return true;
    return i == j;
  };
  for (std::uint32_t n = 1; n < nodes; ++n)
    add_spring(par, of, first + static_cast<std::uint32_t>(random.integer(0, static_cast<int>(n) - 1)),
               first + n);
  for (std::uint32_t n = 0; n < nodes; ++n) {
    const auto i = first + static_cast<std::uint32_t>(random.integer(0, static_cast<int>(nodes) - 1)),
               j = first + static_cast<std::uint32_t>(random.integer(0, static_cast<int>(nodes) - 1));
    if (!joined(i, j)) add_spring(par, of, std::min(i, j), std::max(i, j));
  }
  put_in_order(par.net);
}

}  // namespace godobject
