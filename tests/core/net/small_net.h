// A sheet of 25 nodes on a body that the hand sways, against the oracle, which shares no code with core. Its
// nodes are balls, its anchors springs without rest length.
#pragma once

#include <stdexcept>

#include "tests/core/net/oracle_net.h"
#include "tests/oracle/solve.h"
#include "tests/oracle/target.h"

namespace godobject::small_net {

inline constexpr Real duration = 0.128, spacing = 0.01, radius = 2e-3;  // s, m, m
inline constexpr Stuff sheet{
    .m = 2e-3, .k = 40, .g = 0.05, .k_a = 8, .g_a = 0.02, .radius = radius, .carrier = 0};
inline constexpr ContactLaw floor_law{.k = 200, .c = 0.2, .push_out = 10};

/// on_floor: the sheet hangs askew, and one of its corners is pressed on a plane.
template <class I>
struct NetSmall : Running<NetScene<I>> {
  bool on_floor;
  Pose start;

  NetSmall(Real h, bool floor) : on_floor(floor) {
    auto& par = this->par;
    par.h = h;
    par.gravity_W = Vec3(0, 0, -9.81);
    par.bodies[0].body = rigid_body(0.05, Vec3(1e-5, 1.5e-5, 2e-5).asDiagonal());
    par.bodies[0].coupling = {.k = 200, .g = 4, .k_r = 0.05, .g_r = 1e-3};
    par.bodies[0].device.rise = 0;
    add_sheet(par, sheet, 5, 5, spacing);
    start = {.p = Vec3(0, 0, 0.02), .q = exp_so3(Vec3(0.3, 0.4, 0.1))};
    if (on_floor) {
      Real lowest = 1;
      for (std::size_t n = 0; n < par.net.num_nodes; ++n)
        lowest = std::min(lowest, (start.q * par.net.nodes[n].p_B).z());
      start.p.z() = radius - lowest + 1e-3;  // 1 mm above the floor
      par.contacts.surfaces[par.contacts.num_surfaces++] = {.shape = {}};
      par.contacts.laws[0][0] = floor_law;
    }
    place(this->x, 0, {.X_WB = start, .V_WB = {}});
    place_net(par.net, this->x);
    engage_at(this->x, 0, target(0));
    if (validate(par) != Invalid::nothing) throw std::runtime_error("invalid");
  }
  void solve_tightly() {
    this->par.net.max_iterations = 2000;
    this->par.net.tolerance = 1e-13 / (this->par.h * this->par.h);
  }
  Target target(Real t) const {
    const Real omega = 2 * pi * 5, s = 1 - std::cos(omega * t), ds = omega * std::sin(omega * t);
    const Vec3 by = on_floor ? Vec3(1e-3, 1e-3, -4e-3) : Vec3(4e-3, -3e-3, 5e-3);
    const Vec3 turn = on_floor ? Vec3(Vec3::Zero()) : Vec3(0.1 * Vec3::UnitZ());
    return {.X_WD = {.p = start.p + s * by, .q = exp_so3(Vec3(s * turn)) * start.q},
            .V_WD = {.w = ds * turn, .v = ds * by}};
  }
  /// Positions of the carrier and of the nodes at the end.
  std::vector<Vec3> moved() {
    for (long n = 1; n <= std::lround(duration / this->par.h); ++n) {
      const Target to = target(static_cast<Real>(n) * this->par.h);
      this->in.devices[0] = {};
      this->in.devices[0].target = to;
      this->in.devices[0].engaged = true;
      this->in.devices[0].valid = true;
      this->step();
      if (any(this->out.fault)) throw std::runtime_error("the step reported a fault");
    }
    std::vector<Vec3> p{this->body().X_WB.p};
    for (std::size_t n = 0; n < this->par.net.num_nodes; ++n) p.push_back(this->x.net.nodes[n].p_W);
    return p;
  }
};

struct Truth {
  std::vector<Vec3> p;
  Real deformation = 0;  // how far nodes are from their anchors, in the root of the mean square, m
};

inline Truth solved_exactly(bool on_floor) {
  const auto small = std::make_unique<NetSmall<TrBdf2>>(1e-3, on_floor);
  const auto& par = small->par;
  oracle::Case c;
  c.gravity = par.gravity_W;
  oracle::Body& carrier = c.bodies.emplace_back();
  carrier.name = "carrier";
  carrier.m = par.bodies[0].body.m;
  carrier.I_B = par.bodies[0].body.I_B;
  carrier.start.p = small->start.p;
  carrier.start.q = small->start.q;
  const SpringParams& k = par.bodies[0].coupling;
  carrier.coupling = {
      .k_t = k.k,
      .g_t = k.g,
      .k_r = k.k_r,
      .g_r = k.g_r,
      .target = std::make_shared<oracle::FunctionTarget>([&small](double t) -> oracle::RigidState {
        const Target to = small->target(t);
        return {.p = to.X_WD.p, .q = to.X_WD.q, .v = to.V_WD.v, .w = to.V_WD.w};
      })};
  add_net(*small, c);
  for (std::size_t n = 0; on_floor && n < par.net.num_nodes; ++n)
    c.on_floor.push_back(
        {.body = n + 1, .radius = par.net.nodes[n].radius, .k = floor_law.k, .c = floor_law.c});
  const oracle::Solution solution = oracle::solve(c, std::vector{duration}, on_floor ? 1e-9 : 1e-11);
  Truth truth;
  const auto& end = solution.states[0];
  for (const oracle::RigidState& state : end) truth.p.push_back(state.p);
  for (std::size_t n = 0; n < par.net.num_nodes; ++n)
    truth.deformation += (end[n + 1].p - end[0].p - end[0].q * par.net.nodes[n].p_B).squaredNorm() / 25;
  truth.deformation = std::sqrt(truth.deformation);
  return truth;
}

/// The largest distance from the truth.
template <class I>
Real error(Real h, bool on_floor, bool tight, const Truth& truth) {
  auto net = std::make_unique<NetSmall<I>>(h, on_floor);
  if (tight) net->solve_tightly();
  const std::vector<Vec3> p = net->moved();
  Real most = 0;
  for (std::size_t n = 0; n < p.size(); ++n) most = std::max(most, (p[n] - truth.p[n]).norm());
  return most;
}

}  // namespace godobject::small_net
