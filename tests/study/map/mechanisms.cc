// Families of terms: four-bars with a closing joint, and chains with gears, both with a coupled hand.
#include <array>
#include <memory>

#include "tests/core/term/mechanism.h"
#include "tests/study/map/scenes.h"
#include "tests/study/map/watched_run.h"

namespace godobject::study {
namespace {

constexpr int mechanism_steps = 500;

/// Couples body 0 to a hand at its pose; frees the others.
template <class I>
void couple_first(Running<Mechanism<I>>& run, Random& random) {
  auto& body = run.par.bodies[0];
  const Real k = random.log_uniform(1, 1e7), moment = principal_moments(body.body.I_B).z();
  body.coupling = spring(body.body, k, k * moment / body.body.m,
                         random.integer(0, 3) == 0 ? 0 : random.log_uniform(0.01, 10));
  body.device.rise = 0;
  for (auto& device : run.in.devices) device.engaged = false;
  hold_at(run, run.x.bodies[0].x.X_WB);
  run.in.devices[0].engaged = run.in.devices[0].valid = true;
}

/// Ends of the rods of a four-bar in its plane: O_1, A, B, O_2.
struct FourBar {
  Vec3 A, B, O;
};

/// Returns a four-bar of drawn lengths whose crank is the shortest, at an angle at which it closes.
FourBar drawn_four_bar(Random& random) {
  for (;;) {
    const Real b = random.uniform(0.05, 0.15), c = random.uniform(0.05, 0.15), d = random.uniform(0.05, 0.15),
               a = random.uniform(0.2, 1) * std::min({b, c, d}), angle = random.uniform(-pi, pi);
    const Vec3 A = a * Vec3(std::cos(angle), std::sin(angle), 0), O(d, 0, 0), to = O - A;
    const Real l = to.norm(), along = (l * l + b * b - c * c) / (2 * l), up_sq = b * b - along * along;
    if (!(up_sq > 1e-6)) continue;
    const Vec3 u = to / l;
    return {.A = A, .B = A + along * u + std::sqrt(up_sq) * Vec3(-u.y(), u.x(), 0), .O = O};
  }
}

}  // namespace

template <class I>
void run_loop(Random& random, MapSample& sample) {
  // a universal joint locks the loop
  constexpr std::array kinds{JointKind::hinge, JointKind::ball, JointKind::cylindrical, JointKind::universal};
  constexpr std::array names{"hinge", "ball", "cylindrical", "universal"};
  const auto run = std::make_unique<Running<Mechanism<I>>>();
  run->par.num_bodies = 0;
  run->par.h = random.log_uniform(1e-4, 5e-3);
  run->par.gravity_W = random.integer(0, 1) * 9.81 * random.direction();
  const Quat q_W = random.rotation();
  const FourBar bar = drawn_four_bar(random);
  const auto turned = [&](const Pose& X) { return Pose{.p = q_W * X.p, .q = q_W * X.q}; };
  const auto link = [&](const Vec3& p, const Vec3& q, std::size_t parent, const Vec3& joint) {
    const Real m = random.log_uniform(1e-3, 1), moment = m * (q - p).squaredNorm() / 12;
    return add_link(*run, m, Mat3(Vec3(0.01 * moment, moment, moment).asDiagonal()), turned(rod(p, q)),
                    JointKind::hinge, parent, turned({.p = joint, .q = Quat::Identity()}));
  };
  const std::uint32_t crank = link(Vec3::Zero(), bar.A, world, Vec3::Zero());
  const std::uint32_t coupler = link(bar.A, bar.B, crank, bar.A);
  const std::uint32_t rocker = link(bar.O, bar.B, world, bar.O);
  const auto kind = static_cast<std::size_t>(random.integer(0, 3));
  sample.kind = names[kind];
  close_loop<0>(*run, kinds[kind], coupler, rocker, turned({.p = bar.B, .q = Quat::Identity()}));
  start_turns(run->par, run->x);
  couple_first(*run, random);
  Hand hand = Hand::drawn(random, 0.05);
  hand.axis = q_W * Vec3::UnitZ();  // of the crank's hinge
  watch(*run, mechanism_steps, HandMotion<Mechanism<I>>(*run, hand, mechanism_steps), sample);
}

template <class I>
void run_gear(Random& random, MapSample& sample) {
  const auto run = std::make_unique<Running<Mechanism<I>>>();
  draw_gears<1>(*run, random);
  run->par.h = random.log_uniform(1e-4, 5e-3);
  sample.kind = "gears";
  start_turns(run->par, run->x);
  couple_first(*run, random);
  Hand hand = Hand::drawn(random, 0.05);
  hand.pivot = run->x.bodies[0].x.X_WB.p;
  watch(*run, mechanism_steps, HandMotion<Mechanism<I>>(*run, hand, mechanism_steps), sample);
}

template void run_loop<ImplicitEuler>(Random&, MapSample&);
template void run_loop<TrBdf2>(Random&, MapSample&);
template void run_gear<ImplicitEuler>(Random&, MapSample&);
template void run_gear<TrBdf2>(Random&, MapSample&);

}  // namespace godobject::study
