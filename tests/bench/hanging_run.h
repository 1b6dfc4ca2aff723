// The hanging net of net_contest.h in the core.
#pragma once

#include "core/setup.h"
#include "tests/bench/net_contest.h"
#include "tests/study/net/tube.h"

namespace godobject::bench {

/// The hanging net on anchors of its held edge; the ball is the body, on a stiff coupling.
template <Scene S>
class HangingRun final : public NetPeer {
 public:
  explicit HangingRun(int max_iterations) {
    Params<S>& par = *run_.par;
    par.h = HangingNet::h;
    par.gravity_W = Vec3(0, 0, -HangingNet::gravity);
    const Real m = 1, k = 1e6;
    par.bodies[0].body = rigid_body(m, Mat3(1e-3 * Mat3::Identity()));
    par.bodies[0].coupling =
        par.bodies[0].feedback.gains = {.k = k, .g = 2 * std::sqrt(m * k), .k_r = 100, .g_r = 1};
    par.bodies[0].device.rise = 0;
    add_net(par.net);
    par.net.max_iterations = max_iterations;
    par.contacts.num_surfaces = 1;
    par.contacts.surfaces[0] = {.body = 0,
                                .shape = {.kind = ShapeKind::sphere, .radius = HangingNet::ball_radius}};
    const Real k_c = 10 * HangingNet::k, c = std::sqrt(k_c * HangingNet::m) / 2;
    par.contacts.laws[0][0] = {.k = k_c, .c = c, .mu = HangingNet::mu, .k_t = k_c, .c_t = c};
  }
  bool is_valid() const { return validate(*run_.par) == Invalid::nothing; }
  const NetReport& report() const { return run_.out->net; }

  void restart() override { run_.hold_at(target(0)); }
  void step(std::size_t n) override {
    run_.lead(target(n + 1));
    run_.step();
  }
  Vec3 node(std::uint32_t n) const override { return run_.x->net.nodes[n].p_W; }
  std::size_t num_contacts() const override { return report().num_contacts; }

 private:
  static Target target(std::size_t n) {
    const auto [p, v] = HangingNet::ball(static_cast<double>(n) * HangingNet::h);
    return {.X_WD = {.p = p}, .V_WD = {.v = v}};
  }
  static void add_net(typename S::Net::Params& net) {
    using Of = HangingNet;
    const Real k_held = 1e4 * Of::k;
    for (std::uint32_t n = 0; n < Of::num_nodes; ++n)
      net.nodes[net.num_nodes++] = {.m = Of::m,
                                    .p_B = Of::node(n),
                                    .k = Of::is_held(n) ? k_held : 0,
                                    .g = Of::is_held(n) ? 2 * std::sqrt(k_held * Of::m) : Of::g_air,
                                    .radius = Of::node_radius};
    for (const auto& [i, j] : Of::springs())
      net.springs[net.num_springs++] = {.i = i, .j = j, .k = Of::k, .g = Of::g(), .l_0 = Of::spacing};
    put_in_order(net);
  }

  study::NetRunning<S> run_;
};

}  // namespace godobject::bench
