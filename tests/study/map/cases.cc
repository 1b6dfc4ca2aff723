#include "tests/study/map/cases.h"

#include <array>
#include <memory>

#include "tests/core/contact/usual_scenes.h"
#include "tests/core/net/usual_scene.h"
#include "tests/study/map/held.h"

namespace godobject::study {
namespace {

const Vec3 plain_moments(1e-4, 2e-4, 2.5e-4);  // kg m^2

template <class I>
std::unique_ptr<Running<OneBody<I>>> one_body(Real m, Real k, Real h) {
  auto run = std::make_unique<Running<OneBody<I>>>();
  run->par.h = h;
  run->constants().body = rigid_body(m, Mat3((m * 1e-3 * Vec3(1, 2, 2.5)).asDiagonal()));
  run->constants().coupling = spring(run->constants().body, k, 1e-2 * k);
  place(run->x, 0, {});
  hold(*run, 0, {});
  return run;
}

template <class I>
CaseResult target_jumps() {
  CaseResult result{.name = "target jumps by 10 m", .measure = "left after 3 s, m", .limit = 1e-9};
  const auto run = one_body<I>(0.1, 1e6, 5e-3);
  const Vec3 target(6, -8, 0);
  run->device().target.X_WD.p = target;
  rest(*run, 600, result);
  result.value = (run->body().X_WB.p - target).norm();
  return result;
}

template <class I>
CaseResult target_flips() {
  CaseResult result{.name = "target flips by pi 100 times", .measure = "left after 3 s, rad", .limit = 1e-6};
  const auto run = one_body<I>(0.1, 1e4, 1e-3);
  const auto advance = [&](int n) {
    run->device().target.X_WD.q = n < 100 && n % 2 == 0 ? Quat(0, 0.6, 0, 0.8) : Quat(1, 0, 0, 0);
    run->step();
  };
  watch(*run, 3100, advance, result.run);
  result.value = 2 * run->body().X_WB.q.vec().norm();
  return result;
}

template <class I>
CaseResult deep_overlap() {
  // (35)  the spring may hold as much energy again as the body has at the speed of pushing out
  CaseResult result{
      .name = "ball 50 mm under a plane", .measure = "speed by that of pushing out", .limit = std::sqrt(2)};
  const auto run = std::make_unique<Running<OneTool<I>>>();
  run->par.bodies[0].body = solid_ball(0.05, 0.005);
  add_sphere(run->par, 0, Vec3::Zero(), 0.005);
  add_plane(run->par);
  set_law(run->par, law_of(1e6, 1, 0.3, 0.05));
  place(run->x, 0, {.X_WB = at(Vec3(0, 0, -0.05)), .V_WB = {}});
  run->device().engaged = false;
  const auto advance = [&](int) {
    run->step();
    result.value = std::max(result.value, fastest(*run) / run->par.contacts.laws[0][0].push_out);
  };
  watch(*run, 3000, advance, result.run);
  return result;
}

template <class I>
CaseResult zero_length_springs() {
  CaseResult result{.name = "net springs of no length", .measure = "nodes apart after 4 s, m", .limit = 1e-6};
  const auto run = std::make_unique<Running<NetScene<I>>>();
  auto& net = run->par.net;
  for (std::uint32_t n = 0; n < 8; ++n) {
    const Vec3 p = n % 2 == 0 ? Vec3(Vec3::Zero()) : Vec3(0.01 * n, 0.003 * n * n, 0);
    net.nodes[net.num_nodes++] = {.m = 1e-3, .body = world, .p_B = p, .k = n == 0 ? 10.0 : 0, .g = 0.05};
    for (std::uint32_t i = 0; i < n; ++i)
      net.springs[net.num_springs++] = {.i = i, .j = n, .k = 100, .g = 0.1, .l_0 = 0};
  }
  put_in_order(net);
  run->par.bodies[0].body = rigid_body(0.1, Mat3(plain_moments.asDiagonal()));
  place(run->x, 0, {});
  run->in.devices[0].engaged = false;
  place_net(net, run->x);
  rest(*run, 4000, result);
  for (std::size_t n = 0; n < net.num_nodes; ++n)
    result.value = std::max(result.value, (run->x.net.nodes[n].p_W - run->x.net.nodes[0].p_W).norm());
  return result;
}

template <class I>
CaseResult masses() {
  CaseResult result{.name = "1e-9 to 1e6 kg on 1 kN/m from 0.1 m", .measure = "farthest, m", .limit = 0.1};
  // released 0.1 m from the target: never farther away than at first
  for (Real m = 1e-9; m < 2e6; m *= 10) {
    const auto run = one_body<I>(m, 1e3, 1e-3);
    place(run->x, 0, {.X_WB = at(Vec3(0.1, 0, 0)), .V_WB = {}});
    CaseResult one = result;
    const auto advance = [&](int) {
      run->step();
      result.value = std::max(result.value, run->body().X_WB.p.norm());
    };
    watch(*run, 2000, advance, one.run);
    result.run.fault |= one.run.fault;
    result.run.gain = std::max(result.run.gain, one.run.gain);
  }
  return result;
}

/// Returns how far the scene moves in so many steps after it has come to rest, m.
template <Scene S>
Real creep(Running<S>& run, long steps, MapSample& sample) {
  watch(
      run, 20000, [&](int) { run.step(); }, sample);
  const Vec3 before = run.x.bodies[0].x.X_WB.p;
  for (long n = 0; n < steps && sample.fault == 0; ++n) {
    run.step();
    sample.fault = static_cast<std::uint32_t>(run.out.fault);
  }
  return (run.x.bodies[0].x.X_WB.p - before).norm();
}

template <class I>
CaseResult coupled_at_rest(long steps) {
  CaseResult result{
      .name = "coupled, steps at rest: " + std::to_string(steps), .measure = "moved, m", .limit = 1e-12};
  const auto run = one_body<I>(0.1, 1e3, 1e-3);
  run->par.gravity_W = Vec3(0, 0, -9.81);
  result.value = creep(*run, steps, result.run);
  return result;
}

template <class I>
CaseResult lying_at_rest(long steps) {
  CaseResult result{.name = "pressed on a plane, steps at rest: " + std::to_string(steps),
                    .measure = "moved, m",
                    .limit = 1e-12};
  const auto run = std::make_unique<Running<OneTool<I>>>();
  run->par.gravity_W = Vec3(0, 0, -9.81);
  run->par.bodies[0].body = solid_ball(0.05, 0.005);
  run->par.bodies[0].coupling = spring(run->par.bodies[0].body, 100, 0.01);
  add_sphere(run->par, 0, Vec3::Zero(), 0.005);
  add_plane(run->par, {.p = Vec3::Zero(), .q = exp_so3(Vec3(0.1, 0.05, 0))});
  set_law(run->par, law_of(1e4, 1, 0.5, 0.05));
  place(run->x, 0, {.X_WB = at(Vec3(0, 0, 0.005)), .V_WB = {}});
  hold(*run, 0, at(Vec3(0.001, 0, -0.005)));
  result.value = creep(*run, steps, result.run);
  return result;
}

template <class I>
CaseResult denormals() {
  CaseResult result{.name = "offsets of 1e-310", .measure = "fastest, 1e-300 m/s", .limit = 1};
  const auto run = one_body<I>(0.1, 1e3, 1e-3);
  place(run->x, 0,
        {.X_WB = at(Vec3(1e-310, -1e-310, 1e-310)),
         .V_WB = {.w = Vec3(1e-310, 0, 0), .v = Vec3(0, 1e-310, 0)}});
  const auto advance = [&](int) {
    run->step();
    // the norm of such a velocity is zero
    const RigidBodyState& x = run->body();
    result.value =
        std::max({result.value, x.v_W.cwiseAbs().maxCoeff() * 1e300, x.w_B.cwiseAbs().maxCoeff() * 1e300});
  };
  watch(*run, 1000, advance, result.run);
  return result;
}

template <class I>
void add_cases(std::vector<CaseResult>& all, long steps_at_rest) {
  const std::size_t first = all.size();
  for (const auto one :
       {target_jumps<I>, target_flips<I>, deep_overlap<I>, zero_length_springs<I>, masses<I>, denormals<I>})
    all.push_back(one());
  for (const CaseResult& one : cases_of_joints<I>()) all.push_back(one);
  all.push_back(coupled_at_rest<I>(steps_at_rest));
  all.push_back(lying_at_rest<I>(steps_at_rest));
  for (std::size_t i = first; i < all.size(); ++i) all[i].integrator = I::name;
}

}  // namespace

std::vector<CaseResult> study_cases(long steps_at_rest) {
  std::vector<CaseResult> all;
  add_cases<ImplicitEuler>(all, steps_at_rest);
  add_cases<TrBdf2>(all, steps_at_rest);
  return all;
}

}  // namespace godobject::study
