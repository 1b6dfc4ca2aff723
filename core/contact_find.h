// Which spheres of bodies are near each other, near shapes on other bodies, and near the world.
//
// A body with shapes is touched at its shapes by the spheres of others, one without at its spheres. Bodies on joints
// of one tree do not touch each other. Bound: that of the broad phase; for each pair of bodies with overlapping boxes
// a query for each sphere in the other's box; for each body a query for each of its spheres and surface of the world.
#pragma once

#include "core/broad_phase.h"
#include "core/contact_near.h"
#include "core/sphere_pairs.h"
#include "core/tree.h"

namespace godobject {

/// Half the extents of a shape that bodies carry, about the origin of its frame.
inline Vec3 half_extents(const ShapeParams& shape) noexcept {
  if (shape.kind == ShapeKind::sphere) return Vec3::Constant(shape.radius);
  if (shape.kind == ShapeKind::capsule)
    return Vec3(shape.radius, shape.radius, shape.radius + shape.half_length);
  return shape.half_extents;
}

/// Worthless between steps.
template <class Contacts, std::size_t N>
struct ContactFinder {
  static constexpr std::size_t max_spheres = std::tuple_size_v<decltype(Contacts::Params::spheres)>;
  static constexpr std::size_t max_surfaces = std::tuple_size_v<decltype(Contacts::Params::surfaces)>;
  struct Owned {
    std::uint32_t first_sphere = 0, end_sphere = 0, first_pack = 0, first_surface = 0, end_surface = 0;
    std::uint32_t tree = 0;  // of the bodies on joints that do not touch each other

    bool has_surfaces() const noexcept { return end_surface > first_surface; }
    bool empty() const noexcept { return first_sphere == end_sphere && !has_surfaces(); }
  };
  std::array<Owned, N> owned;
  std::size_t num_fixed = 0;  // surfaces of the world
  std::array<TreePlace, N> at;
  std::array<SpherePack, (max_spheres + 3 * N) / 4> packs;  // spheres in the world, of one body each
  std::array<ShapeParams, max_surfaces> posed;              // surfaces in the world
  std::array<Mat3, max_surfaces> R_WS;                      // and their attitudes
  BroadPhaseScratch<N> broad;
};

/// The material of what a sphere touches.
template <std::size_t max_spheres, std::size_t max_surfaces>
MaterialId touched_material(const ContactParams<max_spheres, max_surfaces>& par,
                            const NearContact& near) noexcept {
  return near.touched < max_surfaces ? par.surfaces[near.touched].material
                                     : par.spheres[near.touched - max_surfaces].material;
}

/// The spheres [s, end) of a body in the world, four to a pack from `packs` on, and the box round what they reach.
/// Returns the number of packs.
template <std::size_t max_spheres, std::size_t max_surfaces>
std::uint32_t place_spheres(const ContactParams<max_spheres, max_surfaces>& par, std::uint32_t s,
                            std::uint32_t end, const TreePlace& at, SpherePack* packs, Aabb& box) noexcept {
  constexpr Real infinity = std::numeric_limits<Real>::infinity();
  Vector3<Pack> lo = Vector3<Pack>::Constant(Pack(infinity)), hi = Vector3<Pack>::Constant(Pack(-infinity));
  std::uint32_t num_packs = 0;
  for (; s < end; s += 4, ++num_packs) {
    const std::array<const BodySphere*, 4> spheres{&par.spheres[s], &par.spheres[std::min(s + 1, end - 1)],
                                                   &par.spheres[std::min(s + 2, end - 1)],
                                                   &par.spheres[std::min(s + 3, end - 1)]};
    const auto of = [&](auto number) noexcept {
      return Pack(number(*spheres[0]), number(*spheres[1]), number(*spheres[2]), number(*spheres[3]));
    };
    SpherePack& pack = packs[num_packs];
    pack.r = of([](const BodySphere& sphere) noexcept { return sphere.radius; });
    const Pack x = of([](const BodySphere&sphere) noexcept { return sphere.p_B.x(); }),
               y = of([](const BodySphere&sphere) noexcept { return sphere.p_B.y(); }),
               z = of([](const BodySphere&sphere) noexcept { return sphere.p_B.z(); });
    const Pack reach = pack.r * (1 + contact_reach);
    for (int k = 0; k < 3; ++k) {
      const Pack c = at.p_W[k] + (at.R_WB(k, 0) * x + at.R_WB(k, 1) * y + at.R_WB(k, 2) * z);
      pack.p_W[k] = c;
      lo[k] = min(lo[k], c - reach);
      hi[k] = max(hi[k], c + reach);
    }
  }
  for (int k = 0; k < 3; ++k) {
    box.lo[k] = std::min({lo[k][0], lo[k][1], lo[k][2], lo[k][3]});
    box.hi[k] = std::max({hi[k][0], hi[k][1], hi[k][2], hi[k][3]});
  }
  return num_packs;
}

/// A shape of a body in the world. Of a box, whose attitude is R_WS, no more than find_on_surfaces() asks for.
inline void place_shape(const ShapeParams& shape, const TreePlace& at, ShapeParams& posed,
                        Mat3& R_WS) noexcept {
  R_WS = at.R_WB * shape.X_WS.q.toRotationMatrix();
  const Vec3 p = at.p_W + at.R_WB * shape.X_WS.p;
  if (shape.kind == ShapeKind::box) {
    posed.kind = shape.kind;
    posed.half_extents = shape.half_extents;
  } else {
    posed = shape;
    posed.X_WS.q = Quat(at.R_WB) * shape.X_WS.q;
  }
  posed.X_WS.p = p;
}

/// Who owns what, and where it all is.
template <class Contacts, std::size_t N>
void place_bodies(const typename Contacts::Params& par, std::size_t num_bodies,
                  ContactFinder<Contacts, N>& w) noexcept {
  std::uint32_t s = 0, o = 0, num_packs = 0;
  for (; o < par.num_surfaces && par.surfaces[o].body == world; ++o) {
    w.posed[o] = par.surfaces[o].shape;
    w.R_WS[o] = w.posed[o].X_WS.q.toRotationMatrix();
  }
  w.num_fixed = o;
  w.broad.num_entries = 0;
  for (std::uint32_t i = 0; i < num_bodies; ++i) {
    const TreePlace& at = w.at[i];
    auto& owned = w.owned[i];
    Aabb& box = w.broad.boxes[i];
    owned.first_sphere = s;
    while (s < par.num_spheres && par.spheres[s].body == i) ++s;
    owned.end_sphere = s;
    owned.first_pack = num_packs;
    num_packs += place_spheres(par, owned.first_sphere, s, at, &w.packs[num_packs], box);
    owned.first_surface = o;
    for (; o < par.num_surfaces && par.surfaces[o].body == i; ++o) {
      place_shape(par.surfaces[o].shape, at, w.posed[o], w.R_WS[o]);
      const Vec3 half = w.R_WS[o].cwiseAbs() * half_extents(par.surfaces[o].shape);
      box.lo = box.lo.cwiseMin(w.posed[o].X_WS.p - half);
      box.hi = box.hi.cwiseMax(w.posed[o].X_WS.p + half);
    }
    owned.end_surface = o;
    if (owned.empty() || !(box.lo.sum() - box.hi.sum() <= 0)) continue;
    w.broad.entries[w.broad.num_entries++].body = i;
  }
}

/// A sphere near something, and where.
struct NearSphere {
  std::uint32_t sphere = 0, touched = 0;
  Real radius = 0, d = 0;
  Vec3 c_W, n_W;
};

/// A sphere of body a near body b, or the world.
template <class Contacts, std::size_t N>
void add_near(const ContactFinder<Contacts, N>& w, std::uint32_t a, std::uint32_t b, std::uint64_t key,
              const NearSphere& at, NearContacts<Contacts::max_contacts>& near) noexcept {
  const auto velocity = [&](std::uint32_t body, const Vec3& p) noexcept -> Vec3 {
    if (body >= N) return Vec3::Zero();
    const TreePlace& place = w.at[body];
    return place.V.v + place.V.w.cross(p - place.a_W);
  };
  const Vec3 p = at.c_W - at.radius * at.n_W;
  const Real v_n = at.n_W.dot(velocity(a, p) - velocity(b, p));
  near.add({.key = key,
            .sphere = at.sphere,
            .touched = at.touched,
            .a = a,
            .b = b,
            .d = at.d,
            .v_n = v_n,
            .c_W = at.c_W,
            .n_W = at.n_W});
}

/// Four points in the frame of a shape.
inline Vector3<Pack> in_frame(const Vec3& p_WS, const Mat3& R_WS, const Vector3<Pack>& p_W) noexcept {
  Vector3<Pack> apart, p_S;
  for (int k = 0; k < 3; ++k) apart[k] = p_W[k] - Pack(p_WS[k]);
  for (int k = 0; k < 3; ++k) p_S[k] = R_WS(0, k) * apart[0] + R_WS(1, k) * apart[1] + R_WS(2, k) * apart[2];
  return p_S;
}

/// Four spheres and a box: bit j of the result, sphere j is near.
inline std::uint32_t near_box(const ShapeParams& box, const Mat3& R_WS, const SpherePack& pack,
                              const Vec3& way_out_S, Pack& d, Vector3<Pack>& n_W) noexcept {
  Vector3<Pack> n_S;
  Pack distance;
  BoxShape::nearest(box.half_extents, in_frame(box.X_WS.p, R_WS, pack.p_W), way_out_S, distance, n_S);
  for (int k = 0; k < 3; ++k) n_W[k] = R_WS(k, 0) * n_S[0] + R_WS(k, 1) * n_S[1] + R_WS(k, 2) * n_S[2];
  d = pack.r - distance;
  return bits(-contact_reach * pack.r < d);
}

/// Four spheres and a half-space: the same.
inline std::uint32_t near_plane(const ShapeParams& plane, const Mat3& R_WS, const SpherePack& pack, Pack& d,
                                Vector3<Pack>& n_W) noexcept {
  Pack distance = 0;
  for (int k = 0; k < 3; ++k) {
    n_W[k] = R_WS(k, 2);
    distance += (pack.p_W[k] - plane.X_WS.p[k]) * R_WS(k, 2);
  }
  d = pack.r - distance;
  return ~bits(d <= -contact_reach * pack.r);
}

/// A direction in the world, and how far to go.
struct WayOut {
  Vec3 n_W = Vec3::UnitZ();
  Real distance = std::numeric_limits<Real>::infinity();
};

/// The shortest way by which all of these spheres leave a box through one of its faces.
inline WayOut way_out(const ShapeParams& box, const Mat3& R_WS, const SpherePack* packs,
                      std::uint32_t num_packs) noexcept {
  Vec3 lo = Vec3::Constant(std::numeric_limits<Real>::infinity()), hi = -lo;
  for (std::uint32_t k = 0; k < num_packs; ++k) {
    const Vector3<Pack> p_S = in_frame(box.X_WS.p, R_WS, packs[k].p_W);
    for (std::size_t j = 0; j < 4; ++j) {
      const Vec3 p = lane(p_S, j), r = Vec3::Constant(packs[k].r[j]);
      lo = lo.cwiseMin(p - r);
      hi = hi.cwiseMax(p + r);
    }
  }
  Eigen::Index up = 0, down = 0;
  const Real way_up = (box.half_extents - lo).minCoeff(&up),
             way_down = (box.half_extents + hi).minCoeff(&down);
  if (way_up <= way_down) return {.n_W = R_WS.col(up), .distance = way_up};
  return {.n_W = -R_WS.col(down), .distance = way_down};
}

/// The shortest way of body a out of body b: out of b's first box, or b's spheres out of a's, if that is shorter.
template <class Contacts, std::size_t N>
Vec3 parting(const ContactFinder<Contacts, N>& w, std::uint32_t a, std::uint32_t b) noexcept {
  if (b < a) return -parting(w, b, a);
  const auto out_of = [&](std::uint32_t of, std::uint32_t i) noexcept {
    const auto &box = w.owned[of], &spheres = w.owned[i];
    const std::uint32_t o = box.first_surface;
    if (!box.has_surfaces() || w.posed[o].kind != ShapeKind::box) return WayOut{};
    return way_out(w.posed[o], w.R_WS[o], &w.packs[spheres.first_pack],
                   (spheres.end_sphere - spheres.first_sphere + 3) / 4);
  };
  const WayOut a_moves = out_of(b, a), b_moves = out_of(a, b);
  return a_moves.distance <= b_moves.distance ? a_moves.n_W : Vec3(-b_moves.n_W);
}

/// The face of a box that looks most in this direction: its normal, in the box's frame.
inline Vec3 face_along(const Mat3& R_WS, const Vec3& n_W) noexcept {
  const Vec3 n_S = R_WS.transpose() * n_W;
  Eigen::Index k = 0;
  n_S.cwiseAbs().maxCoeff(&k);
  return n_S[k] < 0 ? Vec3(-Vec3::Unit(k)) : Vec3(Vec3::Unit(k));
}

/// Spheres of body a against the surfaces [first, end) of body b. A convex body whose spheres are in a box by more than
/// they are wide leaves it through one face, all of it.
template <class Contacts, std::size_t N>
void find_on_surfaces(const ContactFinder<Contacts, N>& w, std::uint32_t a, std::uint32_t b,
                      std::uint64_t pair, std::uint32_t first, std::uint32_t end,
                      NearContacts<Contacts::max_contacts>& near) noexcept {
  const auto& on_a = w.owned[a];
  for (std::uint32_t s = on_a.first_sphere, k = on_a.first_pack; s < on_a.end_sphere; s += 4, ++k) {
    const SpherePack& pack = w.packs[k];
    const std::uint32_t there = on_a.end_sphere - s >= 4 ? 15u : (1u << (on_a.end_sphere - s)) - 1;
    const std::uint32_t sought = b < N ? there & reaching(pack, w.broad.boxes[b]) : there;
    if (sought == 0) continue;
    for (std::uint32_t o = first; o < end; ++o) {
      const ShapeParams& shape = w.posed[o];
      const auto found = [&](std::uint32_t j, Real d, const Vec3& n_W) noexcept {
        add_near(w, a, b, pair | std::uint64_t(s + j) << 15 | o,
                 {.sphere = s + j,
                  .touched = o,
                  .radius = pack.r[j],
                  .d = d,
                  .c_W = lane(pack.p_W, j),
                  .n_W = n_W},
                 near);
      };
      const auto found_all = [&](std::uint32_t hits, const Pack& d, const Vector3<Pack>& n_W) noexcept {
        for (; hits != 0; hits &= hits - 1) {
          const auto j = static_cast<std::uint32_t>(std::countr_zero(hits));
          found(j, d[j], lane(n_W, j));
        }
      };
      Pack d;
      Vector3<Pack> n_W;
      if (shape.kind == ShapeKind::plane) {
        const std::uint32_t hits = sought & near_plane(shape, w.R_WS[o], pack, d, n_W);
        found_all(hits, d, n_W);
        continue;
      }
      if (on_a.has_surfaces() && shape.kind == ShapeKind::box) {
        std::uint32_t hits = sought & near_box(shape, w.R_WS[o], pack, Vec3::UnitZ(), d, n_W);
        if ((hits & bits(pack.r <= d)) != 0) {
          const Vec3 out_W = b < N ? parting(w, a, b)
                                   : way_out(shape, w.R_WS[o], &w.packs[on_a.first_pack],
                                             (on_a.end_sphere - on_a.first_sphere + 3) / 4)
                                         .n_W;
          hits = sought & near_box(shape, w.R_WS[o], pack, face_along(w.R_WS[o], out_W), d, n_W);
        }
        found_all(hits, d, n_W);
        continue;
      }
      for (std::uint32_t hits = sought; hits != 0; hits &= hits - 1) {
        const auto j = static_cast<std::uint32_t>(std::countr_zero(hits));
        const Real radius = pack.r[j], reach = contact_reach * radius;
        const SurfacePoint surface = nearest(shape, lane(pack.p_W, j), radius + reach);
        const Real depth = radius - surface.distance;
        if (!(depth <= -reach)) found(j, depth, surface.n);
      }
    }
  }
}

/// Spheres of both bodies.
template <class Contacts, std::size_t N>
void find_on_spheres(const ContactFinder<Contacts, N>& w, std::uint32_t a, std::uint32_t b,
                     std::uint64_t pair, NearContacts<Contacts::max_contacts>& near) noexcept {
  const auto &on_a = w.owned[a], &on_b = w.owned[b];
  const Vec3 between = w.at[a].p_W - w.at[b].p_W;
  for (std::uint32_t s = on_a.first_sphere; s < on_a.end_sphere; ++s) {
    const Sphere sphere_a = sphere(&w.packs[on_a.first_pack], s - on_a.first_sphere);
    for (std::uint32_t t = on_b.first_sphere; t < on_b.end_sphere; ++t) {
      const Sphere sphere_b = sphere(&w.packs[on_b.first_pack], t - on_b.first_sphere);
      const Real both = sphere_a.r + sphere_b.r, reach = contact_reach * std::min(sphere_a.r, sphere_b.r);
      const Vec3 apart = sphere_a.p_W - sphere_b.p_W;
      const Real distance_sq = apart.squaredNorm();
      if (distance_sq >= (both + reach) * (both + reach)) continue;
      const Real distance = std::sqrt(distance_sq);
      const Vec3 n = direction(apart, distance, direction(between, between.norm(), Vec3::UnitZ()));
      constexpr std::uint32_t spheres = ContactFinder<Contacts, N>::max_surfaces;
      add_near(w, a, b, pair | std::uint64_t(s) << 15 | t,
               {.sphere = s,
                .touched = spheres + t,
                .radius = sphere_a.r,
                .d = both - distance,
                .c_W = sphere_a.p_W,
                .n_W = n},
               near);
    }
  }
}

/// The near contacts of all bodies, where w.at has them.
template <class Contacts, std::size_t N>
void find_contacts(const typename Contacts::Params& par, std::size_t num_bodies,
                   ContactFinder<Contacts, N>& w, NearContacts<Contacts::max_contacts>& near) noexcept {
  near.clear();
  place_bodies(par, num_bodies, w);
  find_overlaps(num_bodies, w.broad,
                [&](std::uint32_t a, std::uint32_t b) { return w.owned[a].tree != w.owned[b].tree; });
  for (std::uint32_t a = 0; a < num_bodies; ++a) {
    w.broad.pairs.for_each_of(a, [&](std::uint32_t b) noexcept {
      const auto &on_a = w.owned[a], &on_b = w.owned[b];
      const std::uint64_t pair = std::uint64_t(a) << 48 | std::uint64_t(b) << 32;
      if (on_b.has_surfaces()) find_on_surfaces(w, a, b, pair, on_b.first_surface, on_b.end_surface, near);
      if (on_a.has_surfaces())
        find_on_surfaces(w, b, a, pair | std::uint64_t(1) << 31, on_a.first_surface, on_a.end_surface, near);
      if (!on_a.has_surfaces() && !on_b.has_surfaces()) find_on_spheres(w, a, b, pair, near);
    });
    if (w.num_fixed > 0)
      find_on_surfaces(w, a, std::uint32_t{N}, std::uint64_t(a) << 48 | std::uint64_t(0xffff) << 32, 0,
                       static_cast<std::uint32_t>(w.num_fixed), near);
  }
  near.put_in_order();
}

}  // namespace godobject
