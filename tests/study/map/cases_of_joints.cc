// Extreme cases of bodies on joints.
#include <memory>

#include "tests/core/contact/bodies/jointed_pile.h"
#include "tests/core/joint/usual_scene.h"
#include "tests/study/map/held.h"

namespace godobject::study {
namespace {

/// Links of 0.1 m along x on joints of one kind, the first on the world, each coupled to its start.
template <class I>
std::unique_ptr<Running<Articulated<I>>> chain(JointKind kind, const std::vector<Real>& masses) {
  using S = Articulated<I>;
  auto run = std::make_unique<Running<S>>();
  run->par.num_bodies = masses.size();
  for (std::size_t i = 0; i < masses.size(); ++i) {
    auto& body = run->par.bodies[i];
    body.body = rigid_body(masses[i], Mat3((masses[i] * 1e-3 * Vec3(0.1, 1, 1)).asDiagonal()));
    body.joint.kind = kind;
    body.joint.parent = i == 0 ? world : i - 1;
    if (i > 0) body.joint.P.p = Vec3(0.05, 0, 0);
    body.joint.C.p = Vec3(-0.05, 0, 0);
    const Pose X_WB = at(Vec3(0.05 + 0.1 * static_cast<Real>(i), 0, 0));
    place<S>(run->x, i, {.X_WB = X_WB, .V_WB = {}});
    run->in.devices[i].engaged = false;
  }
  return run;
}

template <class I>
CaseResult stretched_chain() {
  CaseResult result{
      .name = "straight chain, its hand 1 m beyond", .measure = "speed after 2 s, m/s", .limit = 1e-6};
  const auto run = chain<I>(JointKind::ball, {0.05, 0.05, 0.05, 0.05, 0.05});
  run->par.bodies[4].coupling = spring(run->par.bodies[4].body, 1e6, 10);
  run->in.devices[4].engaged = true;
  hold(*run, 4, at(Vec3(1.45, 0, 0)));
  rest(*run, 2000, result);
  result.value = fastest(*run);
  return result;
}

template <class I>
CaseResult gimbal_lock() {
  CaseResult result{
      .name = "universal joint turned through its singular pose", .measure = "apart, rad", .limit = 1e-4};
  using S = Articulated<I>;
  const auto run = chain<I>(JointKind::universal, {0.05});
  run->par.bodies[0].coupling = spring(run->par.bodies[0].body, 1e3, 1);
  run->in.devices[0].engaged = true;
  const Start start = joined<S>(run->par, run->x, 0, {.q = Vec3(0, pi / 2, 0), .q_dot = Vec3::Zero()});
  place<S>(run->x, 0, start);
  hold(*run, 0, {.p = start.X_WB.p, .q = start.X_WB.q * exp_so3(Vec3(0.7, 0.5, -0.6))});
  const auto advance = [&](int) {
    run->step();
    result.value = std::max(result.value, drift(run->par, run->x).rad);
  };
  watch(*run, 2000, advance, result.run);
  return result;
}

template <class I>
CaseResult masses_in_a_chain() {
  CaseResult result{.name = "links of 1e-9 and 1e6 kg by turns fall", .measure = "apart, m", .limit = 1e-3};
  const auto run = chain<I>(JointKind::ball, {1e-9, 1e6, 1e-9, 1e6});
  run->par.gravity_W = Vec3(0, 0, -9.81);
  const auto advance = [&](int) {
    run->step();
    result.value = std::max(result.value, drift(run->par, run->x).m);
  };
  watch(*run, 2000, advance, result.run);
  return result;
}

template <class I>
CaseResult stop_at_pi() {
  using S = Jointed<I>;
  CaseResult result{
      .name = "hinge strikes stops at pi", .measure = "beyond its energy's depth, rad", .limit = 0};
  constexpr Real moment = 1e-4, rate = 20, k = 10, width = 0.05;
  const auto run = std::make_unique<Running<S>>();
  run->par.num_bodies = 1;
  run->par.h = 1e-3;
  auto& body = run->par.bodies[0];
  body.body = rigid_body(0.05, Mat3((moment * Vec3(1, 1, 1)).asDiagonal()));
  body.joint.kind = JointKind::hinge;
  body.joint.parent = world;
  body.joint.stop.stops[0] = {.lower = -pi, .upper = pi, .k = k, .g = 0, .width = width};
  place(run->x, 0, {.X_WB = {}, .V_WB = {.w = Vec3(0, 0, rate), .v = Vec3::Zero()}});
  start_turns(run->par, run->x);
  run->in.devices[0].engaged = false;
  // beyond the range in which the stiffness rises: k (d^2 - width d + width^2 / 3) / 2 = I w^2 / 2
  const Real e = moment * rate * rate / k;
  const Real deepest = width / 2 + std::sqrt(std::max(e - width * width / 12, 0.0));
  Real angle = 0;
  const auto advance = [&](int) {
    run->step();
    angle = std::max(angle, std::abs(run->x.bodies[0].joint.q[0]));
  };
  watch(*run, 5000, advance, result.run);
  result.value = angle - pi - deepest;
  return result;
}

template <class I>
CaseResult decades_of_stiffness() {
  CaseResult result{.name = "1 to 1e10 N/m in a tree", .measure = "speed after 4 s, m/s", .limit = 1e-6};
  const auto run = chain<I>(JointKind::universal, {0.05, 0.05, 0.05, 0.05, 0.05, 0.05});
  Real k = 1;
  for (std::size_t i = 0; i < 6; ++i, k *= 100) {
    auto& body = run->par.bodies[i];
    if (i > 1) body.joint.parent = (i - 1) / 2;  // two children each
    if (i > 1) {
      const Start start =
          joined<Articulated<I>>(run->par, run->x, i, {.q = Vec3(0.3, i % 2 ? 0.6 : -0.6, 0)});
      place<Articulated<I>>(run->x, i, start);
    }
    body.coupling = spring(body.body, k, 1e-3 * k);
    run->in.devices[i].engaged = true;
    Pose X_WD = run->x.bodies[i].x.X_WB;
    X_WD.p += 0.01 * Vec3(i % 2 ? 1 : -1, 0.5, i % 3 ? 1 : -1).normalized();
    hold(*run, i, X_WD);
  }
  rest(*run, 4000, result);
  result.value = fastest(*run);
  return result;
}

}  // namespace

template <class I>
std::vector<CaseResult> cases_of_joints() {
  return {stretched_chain<I>(), gimbal_lock<I>(), masses_in_a_chain<I>(), stop_at_pi<I>(),
          decades_of_stiffness<I>()};
}

template std::vector<CaseResult> cases_of_joints<ImplicitEuler>();
template std::vector<CaseResult> cases_of_joints<TrBdf2>();

}  // namespace godobject::study
