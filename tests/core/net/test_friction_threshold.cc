// A sheet on a slope, gentle or steep, just below and just above the threshold of its friction. It rests, or
// slides as (sin a - mu cos a) g.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/core/net/usual_scene.h"
#include "tests/support/share.h"

namespace godobject::test_net_friction_threshold {
namespace {

/// ratio: of mu to the slope's tangent. A sheet of nodes, on a light body or of the world, that starts on the
/// plane.
template <class I>
struct OnSlope : Running<NetScene<I>> {
  Real mu, slope;
  bool is_carried;

  OnSlope(unsigned seed, Real ratio) {
    Random random(seed);
    auto& par = this->par;
    par.h = random.log_uniform(5e-4, 2e-3);
    slope = random.uniform(0.02, 0.8);
    mu = ratio * std::tan(slope);
    par.gravity_W = 9.81 * Vec3(std::sin(slope), 0, -std::cos(slope));
    is_carried = random.integer(0, 1) == 0;
    const auto nx = static_cast<std::uint32_t>(random.integer(3, 7)),
               ny = static_cast<std::uint32_t>(random.integer(3, 7));
    const Real m = random.log_uniform(2e-5, 5e-4), k = random.log_uniform(20, 500), a = 0.01;
    Stuff stuff{.m = m, .k = k, .g = 0.5 * std::sqrt(k * m), .radius = 2e-3};
    if (is_carried) {
      stuff.carrier = 0;
      stuff.k_a = random.log_uniform(0.05, 0.5) * k;
      stuff.g_a = 1.4 * std::sqrt(stuff.k_a * m);
    }
    add_sheet(par, stuff, nx, ny, a);
    const Real M = is_carried ? 0.1 * m * nx * ny : 1e-3;
    par.bodies[0].body = rigid_body(M, Mat3(1e-4 * M * Mat3::Identity()));
    this->in.devices[0].engaged = this->in.devices[0].valid = false;
    par.net.max_iterations = random.integer(3, 12);
    const Real k_c = random.log_uniform(5, 200) * m * 1e4, c = std::sqrt(k_c * m);
    par.contacts.surfaces[par.contacts.num_surfaces++] = {.shape = {.X_WS = {.p = Vec3(0, 0, -2e-3)}}};
    par.contacts.laws[0][0] = {.k = k_c, .c = c, .mu = mu, .k_t = k_c, .c_t = c};
    place(this->x, 0, {});
    place_net(par.net, this->x);
    EXPECT_EQ(validate(par), Invalid::nothing);
  }
  /// Returns the motion of the sheet's centre down the slope, m, and its speed, m/s.
  Vec3 motion() const {
    Real p = 0, v = 0;
    const std::size_t num = this->par.net.num_nodes;
    for (std::size_t n = 0; n < num; ++n) {
      p += this->x.net.nodes[n].p_W.x();
      v += this->x.net.nodes[n].v_W.x();
    }
    return Vec3(p, v, 0) / static_cast<Real>(num);
  }
  void run(Real seconds) {
    for (Real t = 0; t < seconds; t += this->par.h) {
      this->step();
      ASSERT_EQ(this->out.fault, Fault::none);
    }
  }
};

/// Ratios of mu to the slope's tangent nearest to the threshold have more cases.
constexpr Real barely_rests = 1 / 0.99, barely_slides = 1 / 1.01;
constexpr unsigned cases_of(Real ratio) { return ratio == barely_rests || ratio == barely_slides ? 100 : 20; }
constexpr Real settled = 0.2, watched = 0.5;  // s

template <class I>
void expect_rest(Real ratio) {
  Real fastest = 0;
  test::Share share;
  for (unsigned seed = 0; seed < cases_of(ratio); ++seed) {
    if (!share.takes()) continue;
    auto run = std::make_unique<OnSlope<I>>(seed, ratio);
    run->run(settled);
    const Real at = run->motion().x();
    run->run(watched);
    const Real creep = std::abs(run->motion().x() - at) / watched;
    fastest = std::max(fastest, creep);
    EXPECT_LT(creep, 1e-9) << "seed " << seed << ", mu " << run->mu << ", tan a " << std::tan(run->slope);
  }
  std::printf("%s, mu = %.2f tan a: creeps at %.1e m/s at most\n", I::name, ratio, fastest);
}

template <class I>
void expect_slide(Real ratio) {
  Real worst = 0;
  test::Share share;
  for (unsigned seed = 0; seed < cases_of(ratio); ++seed) {
    if (!share.takes()) continue;
    auto run = std::make_unique<OnSlope<I>>(seed, ratio);
    run->run(settled);
    const Real before = run->motion().y();
    const auto tick = run->x.tick;
    run->run(watched);
    const Real t = static_cast<Real>(run->x.tick - tick) * run->par.h;
    const Real a = (run->motion().y() - before) / t,
               law = 9.81 * (std::sin(run->slope) - run->mu * std::cos(run->slope));
    worst = std::max(worst, std::abs(a / law - 1));
    EXPECT_NEAR(a / law, 1, 0.01) << "seed " << seed << ", mu " << run->mu << ", tan a "
                                  << std::tan(run->slope);
  }
  std::printf("%s, mu = %.2f tan a: acceleration within %.1e of the law\n", I::name, ratio, worst);
}

TEST(NetFrictionThreshold, RestsBelowWithImplicitEuler) {
  for (const Real ratio : {barely_rests, 1.1, 1.5}) expect_rest<ImplicitEuler>(ratio);
}
TEST(NetFrictionThreshold, RestsBelowWithTrBdf2) {
  for (const Real ratio : {barely_rests, 1.1, 1.5}) expect_rest<TrBdf2>(ratio);
}
TEST(NetFrictionThreshold, SlidesAboveAsTheLawSaysWithImplicitEuler) {
  for (const Real ratio : {barely_slides, 0.9, 0.5}) expect_slide<ImplicitEuler>(ratio);
}
TEST(NetFrictionThreshold, SlidesAboveAsTheLawSaysWithTrBdf2) {
  for (const Real ratio : {barely_slides, 0.9, 0.5}) expect_slide<TrBdf2>(ratio);
}

}  // namespace
}  // namespace godobject::test_net_friction_threshold
