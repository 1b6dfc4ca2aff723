// Residual motion of bodies and nets beyond their contact forces (22), (23), attributed to their contacts as
// forces.
//
// An iteration that ends with a residual moves bodies and nodes by it. Contacts carry this residual: they
// form a tree of bodies and nets. From the leaves on, each end adds its force to one contact and passes it on
// to the next end.
#pragma once

#include "core/solve/pairs.h"

namespace godobject {

/// Contact or attachment between two ends: bodies, or floating nets of the world, numbered after the bodies.
struct Link {
  static constexpr std::uint32_t on_world = NetContactTerm::on_world;
  enum class Kind : std::uint8_t { contact, of_node, attachment };
  std::uint32_t a = 0, b = on_world;
  Kind kind = Kind::contact;
  std::uint32_t k = 0;  // number of the near contact
};

/// Returns the end that a node belongs to: its carrier, or its floating net of the world. Other nodes are
/// held by anchors, as by the world.
template <class Contacts, std::size_t N>
std::uint32_t end_of_node(std::uint32_t node, const BodyContactScratch<Contacts, N>& w) noexcept {
  const auto& par = *w.net.par;
  if (par.nodes[node].body != world) return static_cast<std::uint32_t>(par.nodes[node].body);
  for (std::size_t k = 0; k < par.num_rows; ++k)
    if (par.rows[k].holds(node))
      return w.net.rows[k].is_free ? static_cast<std::uint32_t>(N + k) : Link::on_world;
  return Link::on_world;
}

/// Returns the end that near contact k of nets touches: a body, the world, or the end of a face.
template <class Contacts, std::size_t N>
std::uint32_t touched_end(std::size_t k, const BodyContactScratch<Contacts, N>& w) noexcept {
  const FaceTouch* const face = w.net.touched_face(k);
  return face != nullptr ? end_of_node(face->nodes[0], w) : w.net.near.list[k].b;
}

/// Calls f(link) for all near contacts and attachments. End a of a link is never the world.
template <class Contacts, std::size_t N, class F>
void each_link(const BodyContactScratch<Contacts, N>& w, F f) noexcept {
  for (std::uint32_t k = 0; k < w.near.size; ++k) {
    const NearContact& near = w.near.list[k];
    f(Link{.a = near.a, .b = near.b < N ? near.b : Link::on_world, .k = k});
  }
  if constexpr (Contacts::has_net) {
    const auto of_node = [&](std::uint32_t node, std::uint32_t b, Link::Kind kind, std::uint32_t k) noexcept {
      const std::uint32_t a = end_of_node(node, w);
      if (a == b) return;
      if (a == Link::on_world) f(Link{.a = b, .kind = kind, .k = k});
      else f(Link{.a = a, .b = b, .kind = kind, .k = k});
    };
    if (w.net.num_nodes == 0) return;
    for (std::uint32_t k = 0; k < w.net.near.size; ++k)
      of_node(w.net.near.list[k].a, touched_end(k, w), Link::Kind::of_node, k);
    for (const NetContactTerm& one : w.net.attached()) of_node(one.node, one.body, Link::Kind::attachment, 0);
  }
}

/// Adds on_a(contact) to the largest force of the contacts with the same ends as contact k, and returns this
/// contact. of: the near contacts. forces: of these. are_alike(a, b): true if two near contacts have the same
/// ends; two bodies may be a and b of a contact in either order.
template <class Near, class Forces, class AreAlike, class OnA>
const NearContact& add_to_bearing(std::uint32_t k, const Near& of, Forces& forces, AreAlike are_alike,
                                  OnA on_a) noexcept {
  std::uint32_t bearing = k;
  Real most = 0;
  for (std::uint32_t i = 0, n = 0; i < of.size && n < forces.size; ++i) {
    while (n < forces.size && forces.list[n].key < of.list[i].key) ++n;
    if (n == forces.size || forces.list[n].key != of.list[i].key || !are_alike(of.list[i], of.list[k]))
      continue;
    const Real F_sq = forces.list[n].F_W.squaredNorm();
    if (F_sq > most) {
      most = F_sq;
      bearing = i;
    }
  }
  const NearContact& one = of.list[bearing];
  ContactForces<1> more;
  more.size = 1;
  more.list[0] = {
      .key = one.key, .on = one.on, .a = one.a, .b = one.b, .p_W = one.p_W, .n_W = one.n_W, .F_W = on_a(one)};
  forces.add(more, 1);
  return one;
}

/// Forces on ends, N. F_W: missing forces, which move the ends beyond their contact forces. by_net: forces
/// added to contacts of their nodes and to attachments, which are in no wrench.
template <class Contacts, std::size_t N>
struct Missing {
  static constexpr std::size_t max = [] {
    if constexpr (Contacts::has_net) return N + Contacts::Net::max_nodes / 2 + 1;
    else return N;
  }();
  std::array<Vec3, max> F_W, by_net;

  Missing() noexcept {
    F_W.fill(Vec3::Zero());
    by_net.fill(Vec3::Zero());
  }
};

/// True if the link acts on the end i through a node or an attachment. Wrenches omit such forces.
template <class Contacts, std::size_t N>
bool is_by_net(const Link& link, std::uint32_t i, const BodyContactScratch<Contacts, N>& w) noexcept {
  if constexpr (Contacts::has_net)
    if (link.kind == Link::Kind::of_node) return w.net.near.list[link.k].b != i;
  return link.kind == Link::Kind::attachment;
}

/// Adds the force F_W on end i, and its opposite on the other end, to the contact of a link.
template <class Contacts, std::size_t N>
void add_to_link(const Link& link, std::uint32_t i, const Vec3& F_W,
                 BodyContactScratch<Contacts, N>& w) noexcept {
  const std::uint32_t next = link.a == i ? link.b : link.a;
  if (link.kind == Link::Kind::contact) {
    add_to_bearing(
        link.k, w.near, w.forces,
        [](const NearContact& a, const NearContact& b) noexcept { return pair_of(a) == pair_of(b); },
        [&](const NearContact& one) noexcept { return one.a == i ? F_W : Vec3(-F_W); });
    w.wrenches[i].f += F_W;
    if (next < N) w.wrenches[next].f -= F_W;
  }
  if constexpr (Contacts::has_net) {
    if (link.kind != Link::Kind::of_node) return;
    const auto number = [&](const NearContact& one) noexcept {
      return static_cast<std::size_t>(&one - w.net.near.list.data());
    };
    const auto are_alike = [&](const NearContact& a, const NearContact& b) noexcept {
      return a.b == b.b && touched_end(number(a), w) == touched_end(number(b), w) &&
             end_of_node(a.a, w) == end_of_node(b.a, w);
    };
    const Vec3 on_node = touched_end(link.k, w) != i ? F_W : Vec3(-F_W);
    const NearContact& one = add_to_bearing(link.k, w.net.near, w.net.forces, are_alike,
                                            [&](const NearContact&) noexcept { return on_node; });
    if (one.b < N) w.wrenches[one.b].f -= on_node;
    // a missing force acts on a body at its centre of mass
    const std::uint32_t carrier = end_of_node(one.a, w);
    if (carrier < N) w.wrenches[carrier].tau -= w.net.r[one.a].vec().cross(on_node);
    const FaceTouch* const on = w.net.touched_face(number(one));
    if (on != nullptr && on->carrier < N)
      w.wrenches[on->carrier].tau += at_face(*on, w.net.r).vec().cross(on_node);
  }
}

/// Adds to each end its missing force, along a tree of links, and passes it on to the next end. Roots are
/// ends in contact with the world, which carries the rest; otherwise jointed ends; otherwise any.
template <class Contacts, std::size_t N>
void pass_on(Missing<Contacts, N>& missing, BodyContactScratch<Contacts, N>& w) noexcept {
  constexpr std::size_t max = Missing<Contacts, N>::max;
  std::array<std::uint32_t, max> order;  // ends of a tree
  std::array<Link, max> by, on_world;    // link to the previous end; link to the world
  std::array<bool, max> has_link, is_reached{}, is_linked{}, is_on_world{};
  std::uint32_t num_ends = N;
  if constexpr (Contacts::has_net)
    if (w.net.num_nodes > 0) num_ends += static_cast<std::uint32_t>(w.net.par->num_rows);
  each_link(w, [&](const Link& link) noexcept {
    is_linked[link.a] = true;
    if (link.b != Link::on_world) {
      is_linked[link.b] = true;
    } else if (!is_on_world[link.a] || link.kind != Link::Kind::attachment) {
      is_on_world[link.a] = true;
      on_world[link.a] = link;
    }
  });
  const auto joined = [&](std::uint32_t i) noexcept { return i < N && is_joined(i, w); };
  for (const int rank : {0, 1, 2})
    for (std::uint32_t root = 0; root < num_ends; ++root) {
      if (is_reached[root] || rank != (is_on_world[root] ? 0 : joined(root) ? 1 : 2)) continue;
      std::size_t size = 0;
      const auto reach = [&](std::uint32_t i, bool has, const Link& link) noexcept {
        if (is_reached[i]) return;
        is_reached[i] = true;
        has_link[size] = has;
        by[size] = link;
        order[size++] = i;
      };
      reach(root, is_on_world[root], on_world[root]);
      for (std::size_t n = 0; n < size && is_linked[root]; ++n)
        each_link(w, [&](const Link& link) noexcept {
          if (link.b == Link::on_world) return;
          if (link.a == order[n]) reach(link.b, true, link);
          else if (link.b == order[n]) reach(link.a, true, link);
        });
      for (std::size_t n = size; n-- > 0;) {
        const std::uint32_t i = order[n];
        const Vec3 F_W = missing.F_W[i];
        if (F_W == Vec3::Zero()) continue;
        if (!has_link[n]) {
          if (i < N && !joined(i)) w.wrenches[i].f += F_W;
          continue;
        }
        add_to_link(by[n], i, F_W, w);
        const std::uint32_t next = by[n].a == i ? by[n].b : by[n].a;
        if (is_by_net(by[n], i, w)) missing.by_net[i] += F_W;
        if (next == Link::on_world) continue;
        if (is_by_net(by[n], next, w)) missing.by_net[next] -= F_W;
        missing.F_W[next] += F_W;
      }
    }
}

}  // namespace godobject
