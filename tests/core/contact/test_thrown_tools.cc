// Articulated tools thrown at a floor: their joints hold through the blow (39), and no energy is made of it.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/core/contact/bodies/bricks.h"
#include "tests/core/joint/random_tool.h"

namespace godobject::test_thrown_tools {
namespace {

template <class I>
struct Thrown {
  static constexpr std::size_t max_bodies = 8;
  using Integrator = I;
  using Device = PoseDevice;
  using Joints = TreeJoints<JointStops>;
  using Coupling = DampedSpring;
  using Feedback = None;
  using Contacts = FixedContacts<32, 1, 32>;
};

/// Rods of 0.1 m jointed at their ends, or bodies of any form jointed anywhere.
enum class Form { rods, any };

/// Masses are spread by so much.
template <Scene S>
void make_tool(Running<S>& run, Form form, Real spread, Random& random) {
  const Real size = form == Form::rods ? 0.1 : random.log_uniform(0.02, 0.3);
  run.par.num_bodies = static_cast<std::size_t>(random.integer(2, 8));
  for (std::size_t i = 0; i < run.par.num_bodies; ++i) {
    add_random_body(run.par, i, size, random);
    auto& body = run.par.bodies[i];
    auto& joint = body.joint;
    const Real m = 0.05 * random.log_uniform(1, spread);
    if (form == Form::rods) {
      const Real r = random.log_uniform(0.005, 0.02), across = m * (size * size / 12 + r * r / 4);
      body.body = rigid_body(m, Vec3(across, across, m * r * r / 2).asDiagonal());
      const auto end = [&]() { return Vec3(0, 0, random.integer(0, 1) == 0 ? -0.05 : 0.05); };
      joint.P.p = end();
      joint.C.p = end();
      if (joint.kind == JointKind::slider || joint.kind == JointKind::cylindrical)
        joint.kind = JointKind::universal;
      for (const Real z : {-0.045, 0.045}) add_sphere(run.par, i, Vec3(0, 0, z), 0.005);
    } else {
      const Mat3 I_B = body.body.I_B * (m / body.body.m);
      body.body = rigid_body(m, I_B);
      for (int k = random.integer(1, 4); k > 0; --k) {
        const Vec3 p_B = size * random.uniform(0.2, 1) * random.direction();
        add_sphere(run.par, i, p_B, size * random.log_uniform(0.01, 0.3));
      }
    }
    if (i == 0) joint = {};
  }
  const Real rate = random.integer(0, 3) == 0 ? 0 : random.log_uniform(1, 100);
  const Start start{.X_WB = {.p = Vec3::Zero(), .q = random.rotation()},
                    .V_WB = {.w = rate * random.direction(), .v = Vec3(0, 0, -random.uniform(0, 3))}};
  place<S>(run.x, 0, start);
  for (std::size_t i = 1; i < run.par.num_bodies; ++i) {
    JointMove m{.q = random.vector()};
    const JointKind kind = run.par.bodies[i].joint.kind;
    const int slide = kind == JointKind::slider ? 0 : kind == JointKind::cylindrical ? 1 : -1;
    if (slide >= 0) m.q[slide] *= size;
    m.q *= std::min(Real(1), pi / m.q.norm());
    place<S>(run.x, i, joined(run.par, run.x, i, m));
  }
}

/// The floor 1 cm below it.
template <Scene S>
void put_above_floor(Running<S>& run) {
  add_plane(run.par);
  run.par.gravity_W = Vec3(0, 0, -earth_gravity);
  Real lowest = std::numeric_limits<Real>::infinity();
  for (std::size_t k = 0; k < run.par.contacts.num_spheres; ++k) {
    const BodySphere& sphere = run.par.contacts.spheres[k];
    const Pose& X = run.x.bodies[sphere.body].x.X_WB;
    lowest = std::min(lowest, (X.p + X.q * sphere.p_B).z() - sphere.radius);
  }
  for (std::size_t i = 0; i < run.par.num_bodies; ++i) run.x.bodies[i].x.X_WB.p.z() += 0.01 - lowest;
}

struct Worst {
  Real gain =
      0;  // share of the largest kinetic energy, without the energy of contact springs, which is zero at
          // first and never negative
  Real drift = 0;  // m
};

template <class I>
Worst thrown(Form form, Real spread, unsigned seed) {
  using S = Thrown<I>;
  Random random(2 * seed + (form == Form::rods ? 0 : 1));
  const auto run = std::make_unique<Running<S>>();
  for (auto& device : run->in.devices) device.engaged = false;
  make_tool(*run, form, spread, random);
  put_above_floor(*run);
  run->par.h = random.log_uniform(1e-4, form == Form::rods ? 2e-3 : 5e-3);
  constexpr std::array damping{0.0, 0.1, 1.4, 10.0};
  const Real k = random.log_uniform(1e2, 1e9), zeta = damping[static_cast<std::size_t>(random.integer(0, 3))];
  set_law(run->par, law_of(k, zeta, 0.5 * random.integer(0, 1), 0.05));
  const Real first = energy(run->par, run->x);
  Real moving = kinetic_energy(run->par, run->x);
  Worst worst;
  for (int n = 0; n < std::min(1 / run->par.h, 600.0); ++n) {
    run->step();
    EXPECT_FALSE(any(run->out.fault)) << "step " << n;
    moving = std::max(moving, kinetic_energy(run->par, run->x));
    worst.gain = std::max(worst.gain, (energy(run->par, run->x) - first) / std::max(moving, 1e-9));
    worst.drift = std::max(worst.drift, drift(run->par, run->x).m);
  }
  return worst;
}

#ifdef NDEBUG
constexpr unsigned num_throws = 1500;
#else
constexpr unsigned num_throws = 15;  // builds with assertions and sanitizers take a hundred times as long
#endif

/// Limit, as a share of the largest kinetic energy. One of the 12 000 has 1.3e-3, from the springs of its
/// contacts (decision 035).
constexpr Real most_gain = 2e-3;

template <class I>
class ThrownTools : public ::testing::Test {};
using BothIntegrators = ::testing::Types<ImplicitEuler, TrBdf2>;
TYPED_TEST_SUITE(ThrownTools, BothIntegrators);

TYPED_TEST(ThrownTools, GainNothingAndHold) {
  for (const Form form : {Form::rods, Form::any})
    for (const Real spread : {4.0, 1000.0}) {
      Worst most;
      unsigned num_gaining = 0, num_apart = 0;
      for (unsigned seed = 0; seed < num_throws; ++seed) {
        const Worst w = thrown<TypeParam>(form, spread, seed);
        num_gaining += w.gain > most_gain ? 1 : 0;
        num_apart += w.drift > 1e-5 ? 1 : 0;
        if (w.gain > most_gain || w.drift > 1e-3)
          std::printf("seed %u: gain %.1e, drift %.1e m\n", seed, w.gain, w.drift);
        most = {.gain = std::max(most.gain, w.gain), .drift = std::max(most.drift, w.drift)};
      }
      std::printf("%s, %s, masses to %g: %u gain, %.1e at most; %u apart, %.1e m at most\n", TypeParam::name,
                  form == Form::rods ? "rods" : "any", spread, num_gaining, most.gain, num_apart, most.drift);
      EXPECT_EQ(num_gaining, 0u);
      EXPECT_LE(num_apart, num_throws / 50);
    }
}

}  // namespace
}  // namespace godobject::test_thrown_tools
