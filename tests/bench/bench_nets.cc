// Our step on a net, S6: a tube on a coupled body, pressed on a fixed bar and drawn off again, of 100 to 10 000 nodes. Its
// mass, the area of a contact's spring and the size of the tube are those of all of them.
#include <cmath>
#include <memory>

#include "core/godobject.h"
#include "core/setup.h"
#include "tests/bench/bench.h"

namespace godobject::bench {
namespace {

template <class I, std::size_t nodes>
struct Tube {
  static constexpr std::size_t max_bodies = 1;
  using Integrator = I;
  using Device = PoseDevice;
  using Joints = None;
  using Coupling = DampedSpring;
  using Feedback = LimitedFeedback;
  using Contacts = BodyContacts<1, 1, 4>;
  using Net = MassSpringNet<nodes, 3 * nodes, nodes / 2>;
};

constexpr Real step_s = 1e-3, period_s = 1.5, radius = 0.015, length = 0.09;
constexpr std::size_t num_steps = 1500;

template <Scene S>
class TubeRun {
 public:
  explicit TubeRun(std::uint32_t round) : round_(round) {
    par_->h = step_s;
    auto& body = par_->bodies[0];
    body.body = rigid_body(0.1, Vec3(3.5e-4, 3.5e-4, 2.7e-5).asDiagonal());
    body.coupling = body.feedback.gains = {.k = 1000, .g = 14, .k_r = 1, .g_r = 0.026};
    add_nodes();
    add_springs();
    par_->contacts.num_surfaces = 1;
    par_->contacts.surfaces[0].shape = {.kind = ShapeKind::capsule,
                                        .X_WS = {.p = Vec3(0.032, 0, 0), .q = exp_so3(Vec3(pi / 2, 0, 0))},
                                        .radius = 0.01,
                                        .half_length = 0.1};
    const Real k = 10 * stiffness, c = std::sqrt(k * mass()) / 2;
    par_->contacts.laws[0][0] = {.k = k, .c = c, .mu = 0.3, .k_t = k, .c_t = c};
  }
  bool is_valid() const { return validate(*par_) == Invalid::nothing; }
  std::size_t num_nodes() const { return par_->net.num_nodes; }
  NetReport report() const { return out_->net; }

  void restart() {
    *x_ = {};
    place(*x_, 0, {});
    place_net(par_->net, *x_);
    engage_at(*x_, 0, target(0));
  }
  void step(std::size_t n) {
    const Target to = target(static_cast<Real>(n + 1) * step_s);
    in_->devices[0].X_WD = to.X_WD;
    in_->devices[0].V_WD = to.V_WD;
    in_->devices[0].engaged = in_->devices[0].valid = true;
    godobject::step(*par_, *in_, *x_, *w_, *out_);
  }

 private:
  static constexpr Real stiffness = 200;  // N/m, of a spring

  Real mass() const { return 0.02 / (round_ * round_); }
  /// 24 mm towards the bar and back.
  static Target target(Real t) {
    const Real omega = 2 * pi / period_s;
    return {.X_WD = {.p = Vec3(0.012 * (1 - std::cos(omega * t)), 0, 0)},
            .V_WD = {.v = Vec3(0.012 * omega * std::sin(omega * t), 0, 0)}};
  }
  void add_nodes() {
    // as many anchors as nodes share the stiffness of the whole
    const Real k = 0.1 * stiffness * 1024 / (round_ * round_);
    for (std::uint32_t i = 0; i < round_; ++i) {
      for (std::uint32_t a = 0; a < round_; ++a) {
        const Real t = 2 * pi * (a + 0.5 * (i % 2)) / round_;
        par_->net.nodes[par_->net.num_nodes++] = {
            .m = mass(),
            .body = 0,
            .p_B = Vec3(radius * std::cos(t), radius * std::sin(t), length * (Real(i) / (round_ - 1) - 0.5)),
            .k = k,
            .g = 2 * std::sqrt(k * mass()),
            .radius = 0.0015};
      }
    }
  }
  void add_springs() {
    auto& net = par_->net;
    const auto at = [&](std::uint32_t i, std::uint32_t a) { return i * round_ + (a + round_) % round_; };
    const auto add = [&](std::uint32_t i, std::uint32_t j) {
      net.springs[net.num_springs++] = {.i = i,
                                        .j = j,
                                        .k = stiffness,
                                        .g = 0.2 * std::sqrt(stiffness * mass()),
                                        .l_0 = (net.nodes[i].p_B - net.nodes[j].p_B).norm()};
    };
    for (std::uint32_t i = 0; i < round_; ++i) {
      for (std::uint32_t a = 0; a < round_; ++a) {
        add(at(i, a), at(i, a + 1));
        if (i + 1 == round_) continue;
        add(at(i, a), at(i + 1, a));
        add(at(i, a), at(i + 1, i % 2 == 1 ? a + 1 : a + round_ - 1));
      }
    }
    put_in_order(net);
  }

  std::uint32_t round_;  // nodes in a ring, and rings
  std::unique_ptr<Params<S>> par_ = std::make_unique<Params<S>>();
  std::unique_ptr<State<S>> x_ = std::make_unique<State<S>>();
  std::unique_ptr<Scratch<S>> w_ = std::make_unique<Scratch<S>>();
  std::unique_ptr<Input<S>> in_ = std::make_unique<Input<S>>();
  std::unique_ptr<Output<S>> out_ = std::make_unique<Output<S>>();
};

template <class I, std::size_t nodes>
void add_tube(std::uint32_t round) {
  const std::string who = std::string("net, ") + I::name, scene = "S6/" + std::to_string(round * round);
  add(scene + "/" + who, long_scene, [=](benchmark::State& state) {
    TubeRun<Tube<I, nodes>> run(round);
    if (!run.is_valid()) return state.SkipWithError("the net is not valid");
    double iterations = 0, contacts = 0;
    run.restart();
    for (std::size_t n = 0; n < num_steps; ++n) {
      run.step(n);
      iterations += run.report().iterations;
      contacts = std::max(contacts, static_cast<double>(run.report().num_contacts));
    }
    state.counters["iterations"] = iterations / num_steps;
    state.counters["contacts"] = contacts;
    state.counters["scratch_bytes"] = sizeof(Scratch<Tube<I, nodes>>);
    measure(
        state, {.scene = scene, .who = who}, num_steps, [&] { run.restart(); },
        [&](std::size_t n) { run.step(n); });
  });
}

}  // namespace

void add_our_nets() {
  add_tube<ImplicitEuler, 100>(10);
  add_tube<ImplicitEuler, 1024>(32);
  add_tube<TrBdf2, 1024>(32);
  add_tube<ImplicitEuler, 10000>(100);
}

}  // namespace godobject::bench
