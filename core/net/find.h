// Search for contacts of nodes of nets: with surfaces of the world, shapes on bodies, and spheres of bodies
// without shapes.
//
// Bound: for each four nodes, a query of each surface of the world. Also a query of each surface or sphere of
// a body whose box contains one of them. Nodes do not touch bodies of their carrier's tree, or bodies that
// they are attached to. Nets that touch each other: find_faces.h. Fast nodes, and nodes deep in an obstacle
// of the world, are swept like spheres of bodies (core/contact/find/sweep.h).
#pragma once

#include "core/contact/find/find.h"
#include "core/net/attachment.h"
#include "core/net/face_contacts.h"

namespace godobject {

/// Places the nodes at the predicted end of the stage, four to a pack, with the bounds of their motion.
template <class Net, std::size_t N>
void place_nodes(const typename Net::Params& par, NetStage<Net, N>& w) noexcept {
  for (std::uint32_t n = 0; n < w.num_nodes; ++n) {
    SpherePack& pack = w.spheres[n / 4];
    set_lane(pack.p_W, n % 4, w.p[n].vec());
    pack.r.set(n % 4, par.nodes[n].radius);
  }
  for (std::uint32_t n = static_cast<std::uint32_t>(w.num_nodes); n % 4 != 0; ++n) {
    set_lane(w.spheres[n / 4].p_W, n % 4, w.p[w.num_nodes - 1].vec());
    w.spheres[n / 4].r.set(n % 4, 0);
  }
}

/// Search of one stage.
template <class Contacts, std::size_t N, class Net>
class NetFinder {
 public:
  NetFinder(const typename Contacts::Params& contacts, const typename Net::Params& net,
            const ContactFinder<Contacts, N>& bodies, NetStage<Net, N>& w) noexcept
      : contacts_(contacts), net_(net), bodies_(bodies), w_(w) {}

  /// Finds the contacts in the order of the keys: touched number, then node.
  void find(std::size_t num_bodies) noexcept {
    w_.near.clear();
    if (w_.num_nodes == 0) return;
    place_nodes<Net>(net_, w_);
    const auto num_packs = static_cast<std::uint32_t>((w_.num_nodes + 3) / 4);
    for (std::uint32_t k = 0; k < num_packs; ++k) travel_[k] = travel(k);
    for (std::uint32_t o = 0; o < contacts_.num_surfaces; ++o) find_on_surface(o, num_packs);
    for (std::uint32_t i = 0; i < num_bodies; ++i) {
      const auto& owned = bodies_.owned[i];
      if (!owned.has_surfaces())
        for (std::uint32_t s = owned.first_sphere; s < owned.end_sphere; ++s) find_on_sphere(i, s, num_packs);
    }
    if constexpr (Net::max_faces > 0) FaceFinder<Contacts, N, Net>(net_, bodies_, w_).find();
    w_.near.put_in_order();
    if constexpr (Net::max_faces > 0) set_touched_points<Contacts>(w_);
  }

 private:
  static constexpr std::uint32_t on_world = NetContactTerm::on_world;

  /// Returns a bound of the motion of a pack's nodes in the stage. Nodes without contacts are placed at
  /// infinity.
  Real travel(std::uint32_t k) const noexcept {
    Real fastest_sq = 0;
    for (std::uint32_t n = 4 * k; n < std::min<std::size_t>(4 * k + 4, w_.num_nodes); ++n)
      fastest_sq = std::max(fastest_sq, w_.v[n].vec().squaredNorm());
    return bodies_.since() * std::sqrt(fastest_sq);
  }

  void find_on_surface(std::uint32_t o, std::uint32_t num_packs) noexcept {
    const PlacedShape& shape = bodies_.placed[o];
    const std::size_t body = contacts_.surfaces[o].body;
    const std::uint32_t b = body == world ? on_world : static_cast<std::uint32_t>(body);
    const Real body_travel = b == on_world ? 0 : bodies_.owned[b].travel;
    const Real ball = ball_round(shape);
    for (std::uint32_t k = 0; k < num_packs; ++k) {
      const SpherePack& pack = w_.spheres[k];
      const Real travel = travel_[k] + body_travel;
      Pack d;
      Vector3<Pack> n_W;
      std::uint32_t hits = bits(Pack(0) < pack.r);
      if (shape.kind() == ShapeKind::plane) {
        hits &= near_plane(shape, pack, travel, d, n_W);
        for (; hits != 0; hits &= hits - 1) {
          const auto j = static_cast<std::uint32_t>(std::countr_zero(hits));
          add(4 * k + j, b, o, d[j], lane(n_W, j));
        }
        continue;
      }
      hits &= may_touch(shape, ball, pack, travel);
      for (; hits != 0; hits &= hits - 1) {
        const auto j = static_cast<std::uint32_t>(std::countr_zero(hits));
        const std::uint32_t n = 4 * k + j;
        const Vec3 p_W = w_.p[n].vec();
        const Real radius = pack.r[j], reach = contact_reach * radius + travel;
        SurfacePoint surface = nearest_of(shape, p_W, radius + reach);
        if (b == on_world && (travel > radius || surface.distance < 0)) {
          const SweptContact touch = swept(shape, p_W, -bodies_.since() * w_.v[n].vec(), radius);
          if (touch.touches) {
            add(n, b, o, touch.depth, touch.n_W);
            continue;
          }
          if (shape.kind() == ShapeKind::box && (surface.distance < 0 || touch.was_inside))
            surface = behind_face_before(key_of(n, o), w_.memories.before(), shape, p_W, surface);
        }
        if (radius - surface.distance > -reach) add(n, b, o, radius - surface.distance, surface.n);
      }
    }
  }

  /// Finds contacts with a sphere of body i.
  void find_on_sphere(std::uint32_t i, std::uint32_t s, std::uint32_t num_packs) noexcept {
    const auto& owned = bodies_.owned[i];
    const Sphere other = sphere(&bodies_.packs[owned.first_pack], s - owned.first_sphere);
    for (std::uint32_t k = 0; k < num_packs; ++k) {
      const SpherePack& pack = w_.spheres[k];
      std::uint32_t hits =
          bits(Pack(0) < pack.r) & within(other.p_W, pack, other.r + travel_[k] + owned.travel);
      for (; hits != 0; hits &= hits - 1) {
        const auto j = static_cast<std::uint32_t>(std::countr_zero(hits));
        const Vec3 apart = lane(pack.p_W, j) - other.p_W;
        const Real distance = apart.norm();
        add(4 * k + j, i, static_cast<std::uint32_t>(ContactFinder<Contacts, N>::max_surfaces) + s,
            pack.r[j] + other.r - distance, direction(apart, distance, Vec3::UnitZ()));
      }
    }
  }

  static std::uint64_t key_of(std::uint32_t n, std::uint32_t touched) noexcept {
    return std::uint64_t(touched) << 32 | n;
  }

  /// Adds a contact. touched: number of a surface or, after all of them, of a sphere.
  void add(std::uint32_t n, std::uint32_t b, std::uint32_t touched, Real d, const Vec3& n_W) noexcept {
    const std::size_t carrier = net_.nodes[n].body;
    if (b != on_world && carrier != world && bodies_.owned[b].tree == bodies_.owned[carrier].tree) return;
    if (b != on_world && is_attached(net_.attachments, n, b)) return;
    const Real radius = net_.nodes[n].radius;
    const Vec3 p_W = w_.p[n].vec() - radius * n_W;
    const Real v_n = n_W.dot(w_.v[n].vec() - velocity_at(bodies_, b, p_W));
    if (!(std::max(d, d + bodies_.h * v_n) > -contact_reach * radius)) return;
    w_.near.add({.key = key_of(n, touched),
                 .of = n,
                 .on = touched,
                 .a = n,
                 .b = b,
                 .d = d,
                 .v_n = v_n,
                 .p_W = p_W,
                 .n_W = n_W});
  }

  const typename Contacts::Params& contacts_;
  const typename Net::Params& net_;
  const ContactFinder<Contacts, N>& bodies_;
  NetStage<Net, N>& w_;
  std::array<Real, (Net::max_nodes + 3) / 4> travel_;
};

}  // namespace godobject
