// Places of the spheres and shapes of bodies during a stage, for the search for contacts.
#pragma once

#include "core/contact/candidates.h"
#include "core/contact/find/broad_phase.h"
#include "core/contact/find/placed_shape.h"
#include "core/math/componentwise.h"

namespace godobject {

/// Working storage of the search, undefined between steps.
template <class Contacts, std::size_t N>
struct ContactFinder {
  static constexpr std::size_t max_spheres = std::tuple_size_v<decltype(Contacts::Params::spheres)>;
  static constexpr std::size_t max_surfaces = std::tuple_size_v<decltype(Contacts::Params::surfaces)>;
  // limits of the numbers in the keys of contacts (core/contact/find/before.h)
  static_assert(max_spheres + max_points * max_surfaces <= 1 << 15 && max_surfaces <= 1 << 11 && N < 0xffff);
  struct Owned {
    std::uint32_t first_sphere = 0, end_sphere = 0, first_pack = 0, first_surface = 0, end_surface = 0;
    std::uint32_t tree = 0;  // tree of joints whose bodies do not touch each other
    Real travel = 0;         // bound of the motion of its spheres in the stage, m
    // largest distance of its spheres from the centre of mass, and smallest radius, m
    Real farthest = 0, smallest = 0;
    bool has_points = false;  // true if points of its surfaces touch (core/shape/points.h)
    Twist beyond_predicted;   // its velocity without contacts minus the predicted one
    // mean velocity of its centre since the start of the step minus the predicted one, m/s
    Vec3 mean_beyond_predicted = Vec3::Zero();

    std::uint32_t num_packs() const noexcept { return (end_sphere - first_sphere + 3) / 4; }
    bool has_surfaces() const noexcept { return end_surface > first_surface; }
    bool empty() const noexcept { return first_sphere == end_sphere && !has_surfaces(); }
  };
  /// Returns the time over which the motion is swept, s.
  Real since() const noexcept { return h + swept; }

  std::array<Owned, N> owned;
  Real h = 0;      // length of the stage, s
  Real swept = 0;  // duration of the motion before the stage that is swept with it, s
  const ContactMemories<Contacts::max_contacts>* before = nullptr;  // contact memory of the previous stage
  std::size_t num_fixed = 0;                                        // number of surfaces of the world
  bool world_has_points = false;  // true if points of the world's surfaces touch
  bool may_leave_search = false;  // true if a body without contact forces may leave the region in which its
                                  // contacts are searched
  std::array<TreePlace, N> at;
  // spheres in the world; each pack has spheres of one body
  std::array<SpherePack, (max_spheres + 3 * N) / 4> packs;
  std::array<PlacedShape, max_surfaces> placed;    // surfaces in the world
  std::array<std::uint8_t, max_surfaces> rounded;  // Surface::rounded of each
  [[no_unique_address]] std::conditional_t<Contacts::between_bodies, BroadPhaseScratch<N>, Absent<16>> broad;
};

/// Returns the velocity of a point of a body, or of four points.
template <class T>
Vector3<T> velocity_at(const TreePlace& at, const Vector3<T>& p_W) noexcept {
  const Vector3<T> r = p_W - at.a_W.template cast<T>();
  return at.V.v.template cast<T>() + at.V.w.template cast<T>().cross(r);
}
/// Returns the velocity of a point of a body at the end of the stage; zero for the world.
template <class Contacts, std::size_t N>
Vec3 velocity_at(const ContactFinder<Contacts, N>& w, std::uint32_t body, const Vec3& p_W) noexcept {
  if (body >= N) return Vec3::Zero();
  return velocity_at<Real>(w.at[body], p_W);
}
/// Returns the velocity at which a point of a body came to its place at the end of the stage; zero for the
/// world.
template <class Contacts, std::size_t N>
Vec3 swept_velocity_at(const ContactFinder<Contacts, N>& w, std::uint32_t body, const Vec3& p_W) noexcept {
  if (body >= N) return Vec3::Zero();
  return velocity_at(w, body, p_W) + w.owned[body].mean_beyond_predicted;
}
/// Returns the opening speed of a point of body a, or of four points, along a normal off body b.
template <class T = Real, class Contacts, std::size_t N>
T opening_speed(const ContactFinder<Contacts, N>& w, std::uint32_t a, std::uint32_t b, const Vector3<T>& p_W,
                const Vector3<T>& n_W) noexcept {
  const auto along = [&](const TreePlace& at) noexcept {
    const Vector3<T> r = p_W - at.a_W.template cast<T>(), rxn = r.cross(n_W);
    return T(n_W.dot(at.V.v.template cast<T>()) + rxn.dot(at.V.w.template cast<T>()));
  };
  return b < N ? along(w.at[a]) - along(w.at[b]) : along(w.at[a]);
}

/// Places the spheres of a body in the world, up to number `end`, four to a pack from `packs` on. Returns the
/// number of packs.
template <std::size_t max_spheres, std::size_t max_surfaces, class Owned>
std::uint32_t place_spheres(const ContactParams<max_spheres, max_surfaces>& par, std::uint32_t end,
                            const TreePlace& at, SpherePack* packs, Owned& owned) noexcept {
  std::uint32_t s = owned.first_sphere;
  std::uint32_t num_packs = 0;
  Pack far = 0, small = std::numeric_limits<Real>::infinity();
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
    for (int k = 0; k < 3; ++k)
      pack.p_W[k] = at.p_W[k] + (at.R_WB(k, 0) * x + at.R_WB(k, 1) * y + at.R_WB(k, 2) * z);
    far = max(far, abs(x) + abs(y) + abs(z));
    small = min(small, pack.r);
  }
  owned.farthest = largest(far);
  owned.smallest = -largest(-small);
  return num_packs;
}

/// Returns the bounding box of the spheres, enlarged by the contact reach and the motion in the stage.
inline Aabb box_round(const SpherePack* packs, std::uint32_t num_packs, Real travel) noexcept {
  constexpr Real infinity = std::numeric_limits<Real>::infinity();
  Vector3<Pack> lo = Vector3<Pack>::Constant(Pack(infinity)), hi = Vector3<Pack>::Constant(Pack(-infinity));
  for (std::uint32_t p = 0; p < num_packs; ++p) {
    const Pack reach = packs[p].r * (1 + contact_reach) + travel;
    for (int k = 0; k < 3; ++k) {
      lo[k] = min(lo[k], packs[p].p_W[k] - reach);
      hi[k] = max(hi[k], packs[p].p_W[k] + reach);
    }
  }
  Aabb box;
  for (int k = 0; k < 3; ++k) {
    box.lo[k] = std::min({lo[k][0], lo[k][1], lo[k][2], lo[k][3]});
    box.hi[k] = std::max({hi[k][0], hi[k][1], hi[k][2], hi[k][3]});
  }
  return box;
}

/// Places the surfaces of a body in the world, from number o on. Returns the number after them. Their points
/// that touch count as spheres in the bounds of the body.
template <class Contacts, std::size_t N>
std::uint32_t place_surfaces(const typename Contacts::Params& par, std::uint32_t i, std::uint32_t o,
                             ContactFinder<Contacts, N>& w) noexcept {
  auto& owned = w.owned[i];
  owned.first_surface = o;
  owned.has_points = false;
  for (; o < par.num_surfaces && par.surfaces[o].body == i; ++o) {
    const Surface& surface = par.surfaces[o];
    w.placed[o] = PlacedShape(surface.shape, w.at[i]);
    w.rounded[o] = surface.rounded;
    if (!has_points(surface.shape.kind, surface.rounded)) continue;
    owned.has_points = true;
    owned.farthest = std::max(owned.farthest, surface.shape.X_WS.p.norm() + ball_round(w.placed[o]));
    owned.smallest = std::min(owned.smallest, point_of(surface.shape, 0, half_thickness(surface.shape)).r);
  }
  return owned.end_surface = o;
}

/// Computes the box round the whole contact geometry of a body, its entry of the broad phase. The box is
/// enlarged by the reach of contacts and the motion in the stage, so that no contact depends on its axes.
template <class Contacts, std::size_t N>
void enter_broad_phase(std::uint32_t i, ContactFinder<Contacts, N>& w) noexcept {
  const auto& owned = w.owned[i];
  Aabb& box = w.broad.boxes[i] =
      box_round(w.packs.data() + owned.first_pack, owned.num_packs(), owned.travel);
  for (std::uint32_t o = owned.first_surface; o < owned.end_surface; ++o) {
    const PlacedShape& shape = w.placed[o];
    const Vec3 half_S = half_extents(shape.in_world());
    const Real more = owned.travel + edge_reach * min_component(half_S);
    const Vec3 half = shape.R_WS().cwiseAbs() * half_S + Vec3::Constant(more);
    box.lo = componentwise_min(box.lo, shape.p_W() - half);
    box.hi = componentwise_max(box.hi, shape.p_W() + half);
  }
  if (!owned.empty() && box.lo.sum() - box.hi.sum() <= 0) w.broad.entries[w.broad.num_entries++].body = i;
}

/// Returns a bound of the speed of points up to `farthest` from the centre of mass, m/s.
inline Real speed_bound(const Twist& V, Real farthest) noexcept { return V.v.norm() + V.w.norm() * farthest; }

/// True if a sphere moves by more than its size at velocities `beyond` the predicted ones.
template <class Owned>
bool is_outside_search(const Owned& owned, const Twist& beyond, Real h) noexcept {
  return h * speed_bound(beyond, owned.farthest) > owned.smallest;
}

/// Assigns spheres and surfaces to their bodies and places them.
template <class Contacts, std::size_t N>
void place_bodies(const typename Contacts::Params& par, std::size_t num_bodies,
                  ContactFinder<Contacts, N>& w) noexcept {
  std::uint32_t s = 0, o = 0, num_packs = 0;
  w.world_has_points = false;
  for (; o < par.num_surfaces && par.surfaces[o].body == world; ++o) {
    w.placed[o] = PlacedShape(par.surfaces[o].shape);
    w.rounded[o] = 0;
    w.world_has_points = w.world_has_points || num_points(w.placed[o].kind()) > 0;
  }
  w.num_fixed = o;
  w.may_leave_search = false;
  if constexpr (Contacts::between_bodies) w.broad.num_entries = 0;
  for (std::uint32_t i = 0; i < num_bodies; ++i) {
    auto& owned = w.owned[i];
    owned.first_sphere = s;
    while (s < par.num_spheres && par.spheres[s].body == i) ++s;
    owned.end_sphere = s;
    owned.first_pack = num_packs;
    num_packs += place_spheres(par, s, w.at[i], w.packs.data() + num_packs, owned);
    o = place_surfaces(par, i, o, w);
    owned.travel = w.since() * (speed_bound(w.at[i].V, owned.farthest) + owned.mean_beyond_predicted.norm());
    w.may_leave_search = w.may_leave_search || is_outside_search(owned, owned.beyond_predicted, w.h);
    if constexpr (Contacts::between_bodies) enter_broad_phase(i, w);
  }
}

/// Returns the normal of the box face nearest to a direction, in the box's frame.
inline Vec3 face_along(const Mat3& R_WS, const Vec3& n_W) noexcept {
  const Vec3 n_S = R_WS.transpose() * n_W;
  Eigen::Index k = 0;
  n_S.cwiseAbs().maxCoeff(&k);
  return n_S[k] < 0 ? Vec3(-Vec3::Unit(k)) : Vec3(Vec3::Unit(k));
}

}  // namespace godobject
