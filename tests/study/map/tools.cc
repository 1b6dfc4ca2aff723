// Families without contacts: a free tool, and chains on joints of each kind.
#include <array>
#include <memory>

#include "tests/core/joint/random_tool.h"
#include "tests/core/joint/usual_scene.h"
#include "tests/study/map/scenes.h"
#include "tests/study/map/watched_run.h"

namespace godobject::study {
namespace {

constexpr int tool_steps = 400;

/// Returns a damping ratio: zero in one of four, else 0.01 to 10.
Real drawn_damping(Random& random) { return random.integer(0, 3) == 0 ? 0 : random.log_uniform(0.01, 10); }

/// Returns an angular velocity: none in one of four, else 0.1 to 1000 rad/s.
Vec3 drawn_spin(Random& random) {
  const Real rate = random.integer(0, 3) == 0 ? 0 : random.log_uniform(0.1, 1000);
  return rate * random.direction();
}

/// Engages the device of body i with its target at rest.
template <Scene S>
void engage(Running<S>& run, std::size_t i, const Pose& X_WD) {
  engage_at<S>(run.x, i, {.X_WD = X_WD, .V_WD = {}});
  run.in.devices[i].target = {.X_WD = X_WD, .V_WD = {}};
  run.in.devices[i].engaged = run.in.devices[i].valid = true;
}

}  // namespace

template <class I>
void run_free(Random& random, MapSample& sample) {
  const auto run = std::make_unique<Running<OneBody<I>>>();
  auto& par = run->par;
  par.h = random.log_uniform(1e-4, 5e-3);
  par.gravity_W = random.integer(0, 1) * 9.81 * random.direction();
  const Real m = random.log_uniform(1e-3, 10), moment = m * random.log_uniform(1e-5, 1e-2),
             ratio = random.log_uniform(1, 1e4);
  const Vec3 moments(moment, moment * (1 - random.uniform(0, 0.9) / ratio), moment / ratio);
  auto& body = run->constants();
  body.body = rigid_body(m, random.inertia(moments));
  body.device.rise = 0;
  sample.kind = random.integer(0, 3) == 0 ? "uncoupled" : "coupled";
  if (sample.kind == "coupled")
    body.coupling = spring(body.body, random.log_uniform(1, 1e8), moment * random.log_uniform(1, 1e8),
                           drawn_damping(random));
  place(run->x, 0,
        {.X_WB = {.p = 0.1 * random.vector(), .q = random.rotation()},
         .V_WB = {.w = drawn_spin(random), .v = random.log_uniform(0.01, 5) * random.direction()}});
  engage(*run, 0, {.p = random.log_uniform(1e-3, 1) * random.direction(), .q = random.rotation()});
  watch(*run, tool_steps, HandMotion<OneBody<I>>(*run, Hand::drawn(random, 0.3), tool_steps), sample);
  sample.mass_ratio = ratio;
}

template <class I>
void run_chain(Random& random, MapSample& sample) {
  using S = Articulated<I>;
  constexpr Real size = 0.1;
  constexpr std::array names{"fixed", "ball", "hinge", "slider", "cylindrical", "universal", "mixed"};
  const auto run = std::make_unique<Running<S>>();
  auto& par = run->par;
  par.h = random.log_uniform(1e-4, 5e-3);
  par.gravity_W = random.integer(0, 1) * 9.81 * random.direction();
  const auto kind = static_cast<std::size_t>(random.integer(0, 6));
  sample.kind = names[kind];
  par.num_bodies = static_cast<std::size_t>(random.integer(2, 6));
  const Real ratio = random.log_uniform(1, 1e6);  // of the last link
  for (std::size_t i = 0; i < par.num_bodies; ++i) {
    add_random_body(par, i, size, random);
    auto& joint = par.bodies[i].joint;
    if (kind < joint_kinds.size()) {
      if (joint.kind != JointKind::free) joint.kind = joint_kinds[kind];
      joint.parent = i == 0 ? world : i - 1;
    }
    if (i + 1 == par.num_bodies) {
      const RigidBodyParams& last = par.bodies[i].body;
      par.bodies[i].body = rigid_body(ratio * last.m, Mat3(ratio * last.I_B));
    }
  }
  place_randomly(par, run->x, size, drawn_spin(random).norm(), random);
  const Real jump = random.integer(0, 1) * random.log_uniform(1e-3, 3);
  for (std::size_t i = 0; i < par.num_bodies; ++i) {
    const bool is_coupled = i == 0 || random.integer(0, 1) == 0;
    const Pose& X_WB = run->x.bodies[i].x.X_WB;
    if (!is_coupled) {
      run->in.devices[i].engaged = false;
      continue;
    }
    const RigidBodyParams& body = par.bodies[i].body;
    const Real k = random.log_uniform(1, 1e8);
    par.bodies[i].coupling =
        spring(body, k, k * principal_moments(body.I_B).z() / body.m, drawn_damping(random));
    par.bodies[i].device.rise = 0;
    engage(*run, i,
           {.p = X_WB.p + jump * size * random.direction(),
            .q = X_WB.q * exp_so3(Vec3(std::min(jump, Real(3)) * random.direction()))});
  }
  watch(*run, tool_steps, HandMotion<S>(*run, Hand::drawn(random, 0.1), tool_steps), sample);
}

template void run_free<ImplicitEuler>(Random&, MapSample&);
template void run_free<TrBdf2>(Random&, MapSample&);
template void run_chain<ImplicitEuler>(Random&, MapSample&);
template void run_chain<TrBdf2>(Random&, MapSample&);

}  // namespace godobject::study
