// S6: a tube of springs on a coupled body, pressed on a bar and withdrawn, with any number of nodes. More
// nodes form a larger tube of the same material or, with less spacing, a finer one. Mass and anchors are per
// area, spring stiffness is constant.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>

#include "tests/study/compositions.h"

namespace godobject::study {

/// Data for running a scene with a net, on the heap because a large net has megabytes.
template <Scene S>
struct NetRunning {
  std::unique_ptr<Params<S>> par = std::make_unique<Params<S>>();
  std::unique_ptr<State<S>> x = std::make_unique<State<S>>();
  std::unique_ptr<Scratch<S>> w = std::make_unique<Scratch<S>>();
  std::unique_ptr<Input<S>> in = std::make_unique<Input<S>>();
  std::unique_ptr<Output<S>> out = std::make_unique<Output<S>>();

  /// Places body 0 at the target, and nets at their anchors.
  void hold_at(const Target& D) {
    *x = {};
    place(*x, 0, {.X_WB = D.X_WD, .V_WB = {}});
    place_net(par->net, *x);
    engage_at(*x, 0, D);
    lead(D);
  }
  void lead(const Target& D) {
    in->devices[0] = {.target = D};
    in->devices[0].engaged = in->devices[0].valid = true;
  }
  void step() { godobject::step(*par, *in, *x, *w, *out); }
};

/// Tubes of `round` rings of `round` nodes. spacing: distance of neighbours, m.
template <Scene S>
class TubeRun {
 public:
  static constexpr double h = 1e-3, period = 1.5;  // s
  /// Steps in contact: by symmetry from half a period less 500 steps to half a period more.
  static constexpr std::size_t first_pressed = 300, num_pressed = 900;

  static constexpr double usual_spacing = 0.0029;  // m

  explicit TubeRun(std::uint32_t round, double spacing = usual_spacing) : round_(round), a_(spacing) {
    Params<S>& par = *run_.par;
    par.h = h;
    auto& body = par.bodies[0];
    body.body = rigid_body(0.1, Vec3(3.5e-4, 3.5e-4, 2.7e-5).asDiagonal());
    body.coupling = body.feedback.gains = {.k = 1000, .g = 14, .k_r = 1, .g_r = 0.026};
    add_nodes();
    add_springs();
    par.contacts.num_surfaces = 1;
    par.contacts.surfaces[0].shape = {
        .kind = ShapeKind::capsule,
        .X_WS = {.p = Vec3(radius() + a_ / 2 + 0.0055 + bar, 0, 0), .q = exp_so3(Vec3(pi / 2, 0, 0))},
        .radius = bar,
        .half_length = 0.2};
    const Real k = 10 * stiffness, c = std::sqrt(k * mass()) / 2;
    par.contacts.laws[0][0] = {.k = k, .c = c, .mu = 0.3, .k_t = k, .c_t = c};
  }
  bool is_valid() const { return validate(*run_.par) == Invalid::nothing; }
  std::size_t num_nodes() const { return run_.par->net.num_nodes; }
  NetRunning<S>& running() { return run_; }
  const NetReport& report() const { return run_.out->net; }

  void restart() {
    tick_ = 0;
    run_.hold_at(target(0));
  }
  /// Sets the input of the next step.
  void lead() { run_.lead(target(static_cast<Real>(++tick_) * h)); }
  void step() {
    lead();
    run_.step();
  }
  /// Advances to the contact.
  void press() {
    restart();
    for (std::size_t n = 0; n < first_pressed; ++n) step();
  }

 private:
  static constexpr Real stiffness = 200, bar = 0.01;  // stiffness of a spring, N/m; half size of the bar, m

  Real radius() const { return round_ * a_ / (2 * pi); }
  Real mass() const { return 2.32 * a_ * a_; }      // per node, kg
  Real anchor() const { return 2.38e6 * a_ * a_; }  // N/m
  /// Returns the target: 24 mm towards the bar and back.
  static Target target(Real t) {
    const Real omega = 2 * pi / period;
    return {.X_WD = {.p = Vec3(0.012 * (1 - std::cos(omega * t)), 0, 0)},
            .V_WD = {.v = Vec3(0.012 * omega * std::sin(omega * t), 0, 0)}};
  }
  void add_nodes() {
    auto& net = run_.par->net;
    for (std::uint32_t i = 0; i < round_; ++i)
      for (std::uint32_t a = 0; a < round_; ++a) {
        const Real t = 2 * pi * (a + 0.5 * (i % 2)) / round_;
        net.nodes[net.num_nodes++] = {
            .m = mass(),
            .body = 0,
            .p_B = Vec3(radius() * std::cos(t), radius() * std::sin(t), a_ * (i - 0.5 * (round_ - 1.0))),
            .k = anchor(),
            .g = 2 * std::sqrt(anchor() * mass()),
            .radius = a_ / 2};
      }
  }
  void add_springs() {
    auto& net = run_.par->net;
    const auto at = [&](std::uint32_t i, std::uint32_t a) { return i * round_ + (a + round_) % round_; };
    const auto add = [&](std::uint32_t i, std::uint32_t j) {
      net.springs[net.num_springs++] = {.i = i,
                                        .j = j,
                                        .k = stiffness,
                                        .g = 0.2 * std::sqrt(stiffness * mass()),
                                        .l_0 = (net.nodes[i].p_B - net.nodes[j].p_B).norm()};
    };
    for (std::uint32_t i = 0; i < round_; ++i)
      for (std::uint32_t a = 0; a < round_; ++a) {
        add(at(i, a), at(i, a + 1));
        if (i + 1 == round_) continue;
        add(at(i, a), at(i + 1, a));
        add(at(i, a), at(i + 1, i % 2 == 1 ? a + 1 : a + round_ - 1));
      }
    put_in_order(net);
  }

  std::uint32_t round_;
  Real a_;
  std::size_t tick_ = 0;
  NetRunning<S> run_;
};

}  // namespace godobject::study
