// Random nets over the ranges of stiffness, mass, damping and step of scenes, with their ordeals.
#pragma once

#include <sstream>

#include "tests/core/net/net_scene.h"

namespace godobject {

enum class Ordeal {
  held,        // at rest but for random velocities; the target rests
  free,        // no coupling: flies with random velocities, turning
  inside_out,  // mirrored at the start
  far_node,    // one node 1 m away at the start
  swayed,      // the hand sways at up to 5 m/s and 100 m/s^2, then rests
  pinched,     // drawn between two boxes of the world that are nearer to each other than it is wide
  jaws,        // between two boxes on bodies that close on it
  hole,        // drawn through a gap smaller than itself, between two capsules
};
inline constexpr int num_ordeals = 8;
inline constexpr const char* ordeal_names[] = {"held", "free",    "inside_out", "far_node",
                                               "led",  "pinched", "jaws",       "hole"};

/// Quantities varied on purpose; the rest is drawn.
struct Drawn {
  Ordeal ordeal = Ordeal::held;
  int shape = 0;  // sheet, tube, tangle
  Real a = 0, k = 0, m = 0, zeta = 0, anchors = 0, h = 0, gravity = 0, size = 0;
  Real carrier_m = 0, coupling_k = 0, contact_k = 0, contact_zeta = 0, mu = 0;
  bool on_carrier = true;
  int cap = 12;
  Real peak_v = 0, omega = 0;  // of the hand
  Vec3 way = Vec3::Zero();     // its direction
  Real rest_after = 0;         // s

  /// 400, or so many that the hand has come to rest a third before the end, however short they are.
  int steps() const {
    const bool is_moved = ordeal == Ordeal::swayed || ordeal == Ordeal::pinched || ordeal == Ordeal::jaws ||
                          ordeal == Ordeal::hole;
    return is_moved ? std::max(400, static_cast<int>(std::ceil(1.5 * rest_after / h))) : 400;
  }

  std::string text() const {
    std::ostringstream os;
    os.precision(3);
    os << ordeal_names[static_cast<int>(ordeal)]
       << (shape == 0   ? " sheet"
           : shape == 1 ? " tube"
                        : " tangle")
       << " a " << a << " k " << k << " m " << m << " h " << h << " s=h2k/m " << h * h * k / m << " zeta "
       << zeta << " anchors " << anchors << (on_carrier ? "" : " world") << " carrier " << carrier_m
       << " coupling " << coupling_k << " contact k " << contact_k << " z " << contact_zeta << " mu " << mu
       << " cap " << cap << " g " << gravity << " hand v " << peak_v << " w " << omega;
    return os.str();
  }
};

template <class I>
struct RandomNet : Running<NetScene<I>> {
  using S = NetScene<I>;
  Drawn of;
  Vec3 axis_0, axis_1;
  EnergyBalance<S> balance;

  /// change(drawn): deviation of a test from the drawn case
  template <class Change = void (*)(Drawn&)>
  explicit RandomNet(
      unsigned seed, int only = -1, Change change = [](Drawn&) {}) {
    Random random(seed);
    draw(random, only < 0 ? static_cast<Ordeal>(seed % num_ordeals) : static_cast<Ordeal>(only));
    change(of);
    build(random);
  }

  void draw(Random& random, Ordeal ordeal) {
    of.ordeal = ordeal;
    of.shape = random.integer(0, 2);
    of.a = random.log_uniform(1e-3, 1e-2);
    of.k = random.log_uniform(1, 1e8);
    of.m = random.log_uniform(1e-6, 1);
    of.zeta = random.integer(0, 2) == 0 ? 0 : random.log_uniform(0.01, 2);
    const bool is_drawn_in = ordeal == Ordeal::pinched || ordeal == Ordeal::hole;
    of.anchors = !is_drawn_in && random.integer(0, 3) == 0 ? 0 : random.log_uniform(1e-3, 10);
    of.h = random.log_uniform(1e-4, 5e-3);
    of.gravity = random.integer(0, 1) * 9.81;
    of.on_carrier = ordeal == Ordeal::pinched || ordeal == Ordeal::swayed || ordeal == Ordeal::hole ||
                    ordeal == Ordeal::free || random.integer(0, 3) > 0;
    of.carrier_m = random.log_uniform(1e-2, 1);
    of.coupling_k = random.log_uniform(100, 1e4);
    of.contact_k = random.log_uniform(1, 1e8);  // whatever k is: either may be larger by many decades
    of.contact_zeta = random.uniform(0, 1);
    of.mu = random.integer(0, 1) * random.uniform(0, 1);
    const int caps[] = {12, 12, 12, 1, 2, 4};
    of.cap = caps[random.integer(0, 5)];
    of.peak_v = random.log_uniform(0.01, 5);
    of.omega = random.log_uniform(1, 100) / of.peak_v;  // a = v omega
    of.way = random.direction();
    of.rest_after = 0.2;
  }

  void build(Random& random) {
    auto& par = this->par;
    par.h = of.h;
    par.gravity_W = Vec3(0, 0, -of.gravity);
    par.num_bodies = of.ordeal == Ordeal::jaws ? 3 : 1;
    // a net pulled through a hole follows the hand within its motion; otherwise it would not reach the hole
    constexpr Real following = 50;  // rad/s
    const bool is_drawn_in = of.ordeal == Ordeal::pinched || of.ordeal == Ordeal::hole;
    if (is_drawn_in) of.anchors = std::max(of.anchors, following * following * of.m / of.k);
    Stuff stuff{.m = of.m,
                .k = of.k,
                .g = 2 * of.zeta * std::sqrt(of.k * of.m),
                .k_a = of.anchors * of.k,
                .radius = Real(0.4) * of.a,
                .carrier = of.on_carrier ? 0 : world};
    stuff.g_a = 2 * of.zeta * std::sqrt(stuff.k_a * of.m);
    const auto count = [&](int a, int b) { return static_cast<std::uint32_t>(random.integer(a, b)); };
    if (of.shape == 0) add_sheet(par, stuff, count(2, 8), count(2, 8), of.a);
    if (of.shape == 1) add_tube(par, stuff, count(3, 8), count(2, 8), of.a);
    if (of.shape == 2) add_tangle(random, par, stuff, count(4, 64), of.a);
    for (std::size_t n = 0; n < par.net.num_nodes; ++n)
      of.size = std::max(of.size, par.net.nodes[n].p_B.norm());
    par.net.max_iterations = of.cap;
    if (is_drawn_in) {
      const Real mass = of.carrier_m + static_cast<Real>(par.net.num_nodes) * of.m;
      of.coupling_k = std::max(of.coupling_k, following * following * mass);
    }
    const Real side = 2 * of.size;
    for (std::size_t i = 0; i < par.num_bodies; ++i) {
      par.bodies[i].body =
          rigid_body(of.carrier_m, (of.carrier_m / 6 * side * side * Vec3(1, 1.3, 0.7)).asDiagonal());
      const Real omega = std::sqrt(of.coupling_k / of.carrier_m),
                 k_r = of.carrier_m / 6 * side * side * omega * omega;
      if (of.ordeal != Ordeal::free)
        par.bodies[i].coupling = {.k = of.coupling_k,
                                  .g = 1.4 * std::sqrt(of.coupling_k * of.carrier_m),
                                  .k_r = k_r,
                                  .g_r = 1.4 * k_r / omega};
      par.bodies[i].device.rise = 0;
      place(this->x, i, {});
      this->in.devices[i].engaged = of.ordeal != Ordeal::free;
      this->in.devices[i].valid = of.ordeal != Ordeal::free;
    }
    surround(random);
    place_net(par.net, this->x);
    add_bias(random);
    for (std::size_t i = 0; i < par.num_bodies; ++i)
      if (of.ordeal != Ordeal::free) {
        engage_at(this->x, i, Target{.X_WD = this->in.devices[i].target.X_WD, .V_WD = {}});
      }
    if (validate(par) != Invalid::nothing) throw std::runtime_error("invalid");
    balance.start(par, this->x);
  }

  void surround(Random& random) {
    auto& par = this->par;
    auto& contacts = par.contacts;
    const Real c = 2 * of.contact_zeta * std::sqrt(of.contact_k * of.m);
    contacts.laws[0][0] = {.k = of.contact_k, .c = c, .mu = of.mu, .k_t = of.contact_k, .c_t = c};
    const auto box = [&](std::size_t body, const Vec3& p, const Quat& q) {
      contacts.surfaces[contacts.num_surfaces++] = {
          .body = body,
          .shape = {
              .kind = ShapeKind::box, .X_WS = {.p = p, .q = q}, .half_extents = of.size * Vec3(1, 2, 2)}};
    };
    if (of.ordeal == Ordeal::pinched) {
      axis_0 = random.direction();  // along which the net goes
      axis_1 = axis_0.unitOrthogonal();
      const Real gap = random.uniform(0.1, 0.8) * of.size;
      const Quat q = Quat::FromTwoVectors(Vec3::UnitX(), axis_1);
      for (const Real side : {-1.0, 1.0})
        box(world, 3.5 * of.size * axis_0 + side * (of.size + gap) * axis_1, q);
    }
    if (of.ordeal == Ordeal::jaws) {
      axis_0 = random.direction();
      const Quat q = Quat::FromTwoVectors(Vec3::UnitX(), axis_0);
      for (std::size_t i = 1; i < 3; ++i) {
        const Vec3 p = (i == 1 ? 1 : -1) * 2.5 * of.size * axis_0;
        place(this->x, i, {.X_WB = {.p = p, .q = q}, .V_WB = {}});
        this->in.devices[i].target.X_WD = {.p = p, .q = q};
        box(i, Vec3::Zero(), Quat::Identity());
      }
    }
    if (of.ordeal == Ordeal::hole) {
      axis_0 = random.direction();  // along which the net goes
      axis_1 = axis_0.unitOrthogonal();
      const Quat q = Quat::FromTwoVectors(Vec3::UnitZ(), axis_0.cross(axis_1));
      const Real r = 0.5 * of.size, gap = random.uniform(0.1, 0.8) * of.size;
      for (int s = -1; s < 2; s += 2)
        contacts.surfaces[contacts.num_surfaces++] = {
            .shape = {.kind = ShapeKind::capsule,
                      .X_WS = {.p = 2.5 * of.size * axis_0 + s * (r + gap) * axis_1, .q = q},
                      .radius = r,
                      .half_length = 3 * of.size}};
    }
  }

  void add_bias(Random& random) {
    auto& nodes = this->x.net.nodes;
    const std::size_t num = this->par.net.num_nodes;
    if (of.ordeal == Ordeal::inside_out) {
      const Vec3 u = random.direction();
      const bool through_a_point = random.integer(0, 1) == 0;
      for (std::size_t n = 0; n < num; ++n) {
        if (through_a_point) nodes[n].p_W = -nodes[n].p_W;
        else nodes[n].p_W -= 2 * u * u.dot(nodes[n].p_W);
      }
    }
    if (of.ordeal == Ordeal::far_node)
      nodes[random.integer(0, static_cast<int>(num) - 1)].p_W += random.direction();
    if (of.ordeal == Ordeal::held || of.ordeal == Ordeal::free) {
      const Real v = random.log_uniform(0.01, 5), turn = random.log_uniform(0.1, 100),
                 stretch = random.log_uniform(0.01, 1);
      const Vec3 w = turn * random.direction(), v_0 = v * random.direction();
      for (std::size_t n = 0; n < num; ++n) {
        if (of.ordeal == Ordeal::free) nodes[n].p_W += stretch * of.a * random.vector();
        nodes[n].v_W = v * 0.3 * random.vector();
        if (of.ordeal == Ordeal::free) nodes[n].v_W += v_0 + w.cross(nodes[n].p_W);
      }
      if (of.ordeal == Ordeal::free) place(this->x, 0, {.X_WB = {}, .V_WB = {.w = w, .v = v_0}});
    }
  }

  /// The targets at the end of the coming step.
  void lead() {
    const Real t = static_cast<Real>(this->x.tick + 1) * of.h;
    auto& in = this->in;
    const Real moving = std::min(t, of.rest_after);
    if (of.ordeal == Ordeal::swayed) {
      const Real A = of.peak_v / of.omega;
      in.devices[0].target.X_WD.p = A * (1 - std::cos(of.omega * moving)) * of.way;
      in.devices[0].target.V_WD.v =
          t < of.rest_after ? Vec3(of.peak_v * std::sin(of.omega * moving) * of.way) : Vec3(Vec3::Zero());
    }
    const Real s = 0.5 * (1 - std::cos(pi * moving / of.rest_after));
    const Real ds = t < of.rest_after ? 0.5 * pi / of.rest_after * std::sin(pi * moving / of.rest_after) : 0;
    if (of.ordeal == Ordeal::hole || of.ordeal == Ordeal::pinched) {
      in.devices[0].target.X_WD.p = 5 * of.size * s * axis_0;
      in.devices[0].target.V_WD.v = 5 * of.size * ds * axis_0;
    }
    if (of.ordeal == Ordeal::jaws) {
      for (std::size_t i = 1; i < 3; ++i) {
        const Real sign = i == 1 ? 1 : -1;
        in.devices[i].target.X_WD.p = sign * of.size * (2.5 - 1.4 * s) * axis_0;
        in.devices[i].target.V_WD.v = -sign * of.size * 1.4 * ds * axis_0;
      }
    }
  }

  /// How far nodes and bodies are from the origin, about which the scene lies, at most, m.
  Real reach() const {
    Real most_sq = 0;
    for (std::size_t i = 0; i < this->par.num_bodies; ++i)
      most_sq = std::max(most_sq, this->x.bodies[i].x.X_WB.p.squaredNorm());
    for (std::size_t n = 0; n < this->par.net.num_nodes; ++n)
      most_sq = std::max(most_sq, this->x.net.nodes[n].p_W.squaredNorm());
    return std::sqrt(most_sq);
  }

  bool step_and_watch() {
    lead();
    this->step();
    const bool taken = !has(this->out.fault, Fault::state_not_finite | Fault::energy_gained);
    if (taken) balance.observe(this->par, this->x, this->w, this->out);
    return taken;
  }
};

}  // namespace godobject
