// Scenes of nets whose surfaces touch each other and themselves.
#pragma once

#include <map>

#include "tests/core/net/net_scene.h"

namespace godobject {

template <class I, std::size_t contacts = 256>
struct FaceScene : NetScene<I> {
  using Net = MassSpringNet<140, 900, contacts, 0, 280>;
};

/// Adds a face.
template <class S>
void add_face(Params<S>& par, std::uint32_t i, std::uint32_t j, std::uint32_t k, bool touches_own = false) {
  par.net.faces.list.at(par.net.faces.size++) = {.nodes = {i, j, k}, .touches_own = touches_own};
}

/// Adds a sheet of add_sheet() with faces, moved to X. Returns its first node.
template <class S>
std::uint32_t add_touching_sheet(Params<S>& par, const Stuff& of, std::uint32_t nx, std::uint32_t ny, Real a,
                                 const Pose& X, bool touches_own = false) {
  const auto first = static_cast<std::uint32_t>(par.net.num_nodes);
  add_sheet(par, of, nx, ny, a);
  for (std::size_t n = first; n < par.net.num_nodes; ++n)
    par.net.nodes[n].p_B = X.p + X.q * par.net.nodes[n].p_B;
  for (std::uint32_t y = 0; y + 1 < ny; ++y)
    for (std::uint32_t x = 0; x + 1 < nx; ++x) {
      const std::uint32_t n = first + y * nx + x;
      add_face(par, n, n + 1, n + nx + 1, touches_own);
      add_face(par, n, n + nx + 1, n + nx, touches_own);
    }
  put_in_order(par.net);
  return first;
}

/// Adds a bag: a closed ellipsoid, an octahedron divided `times`, with springs along its edges and faces.
/// Returns its first node.
template <class S>
std::uint32_t add_bag(Params<S>& par, const Stuff& of, const Vec3& half, int times, const Pose& X,
                      bool touches_own = true) {
  std::vector<Vec3> p{Vec3::UnitX(),  -Vec3::UnitX(), Vec3::UnitY(),
                      -Vec3::UnitY(), Vec3::UnitZ(),  -Vec3::UnitZ()};
  std::vector<std::array<std::uint32_t, 3>> faces;
  for (const std::uint32_t x : {0u, 1u})
    for (const std::uint32_t y : {2u, 3u})
      for (const std::uint32_t z : {4u, 5u}) {
        const bool turned = (x + y + z) % 2 == 1;
        faces.push_back(turned ? std::array{x, z, y} : std::array{x, y, z});
      }
  for (int i = 0; i < times; ++i) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [at, is_new] = middles.try_emplace(std::minmax(a, b), p.size());
      if (is_new) p.push_back((p[a] + p[b]).normalized());
      return at->second;
    };
    std::vector<std::array<std::uint32_t, 3>> finer;
    for (const auto& [a, b, c] : faces) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    faces = finer;
  }
  const auto first = static_cast<std::uint32_t>(par.net.num_nodes);
  for (const Vec3& at : p) add_node(par, of, X.p + X.q * half.cwiseProduct(at));
  std::map<std::pair<std::uint32_t, std::uint32_t>, bool> edges;
  for (const auto& f : faces) {
    for (std::size_t j = 0; j < 3; ++j) edges[std::minmax(first + f[j], first + f[(j + 1) % 3])] = true;
    add_face(par, first + f[0], first + f[1], first + f[2], touches_own);
  }
  for (const auto& [ends, yes] : edges) add_spring(par, of, ends.first, ends.second);
  put_in_order(par.net);
  return first;
}

/// Momentum and angular momentum about the origin of the nodes of a scene, and a bound of the latter.
struct NetMomenta {
  Vec3 p = Vec3::Zero(), L = Vec3::Zero();
  Real speed = 0, turn = 0;
};
template <class Scene>
NetMomenta momenta_of(const Scene& s) {
  NetMomenta sum;
  for (std::size_t n = 0; n < s.par.net.num_nodes; ++n) {
    const auto& node = s.x.net.nodes[n];
    const Vec3 p = s.par.net.nodes[n].m * node.v_W;
    sum.p += p;
    sum.L += node.p_W.cross(p);
    sum.speed += p.norm();
    sum.turn += node.p_W.norm() * p.norm();
  }
  return sum;
}

/// Returns the sum of the contact forces of nodes on elements that accept(force), N.
template <class Scene, class Accept>
Vec3 force_of_nodes(const Scene& s, Accept accept) {
  Vec3 F = Vec3::Zero();
  const auto& all = s.w.means.of_nodes;
  for (std::size_t i = 0; i < all.size; ++i)
    if (accept(all.list[i])) F += all.list[i].F_W;
  return F;
}

}  // namespace godobject
