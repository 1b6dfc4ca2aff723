// The small net against the oracle: the order of each integrator, free and pressed on a plane.
#include <gtest/gtest.h>

#include "tests/core/net/small_net.h"
#include "tests/core/net/usual_scene.h"

namespace godobject::test_net_reference {
namespace {

using namespace small_net;

template <class I>
Real order(const Truth& truth) {
  const Real e_1 = error<I>(1e-3, false, true, truth), e_2 = error<I>(5e-4, false, true, truth),
             e_3 = error<I>(2.5e-4, false, true, truth);
  std::printf("%s: %.2e, %.2e, %.2e m of a deformation of %.2e m, order %.2f\n", I::name, e_1, e_2, e_3,
              truth.deformation, std::log2(e_2 / e_3));
  return std::log2(e_2 / e_3);
}

TEST(NetReference, ConvergesAsItsIntegratorDoes) {
  const Truth truth = solved_exactly(false);
  EXPECT_GT(truth.deformation, 1e-3);
  EXPECT_GE(order<ImplicitEuler>(truth), 0.9);
  EXPECT_GE(order<TrBdf2>(truth), 1.9);
  EXPECT_LE(error<TrBdf2>(1e-3, false, true, truth), 0.01 * truth.deformation);
  EXPECT_LE(error<TrBdf2>(1e-3, false, false, truth), 0.01 * truth.deformation)
      << "with the default iterations";
}

/// The residual of iterations decreases with the step like the error of the integrator: a step half as long
/// is never worse.
template <class I>
Real order_by_default(const Truth& truth) {
  const Real steps[] = {4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4};
  Real first = 0, last = 0;
  for (const Real h : steps) {
    const Real e = error<I>(h, false, false, truth);
    std::printf("%s, default iterations, %g ms: %.2e m\n", I::name, 1e3 * h, e);
    if (last > 0) EXPECT_LT(e, 0.7 * last) << "at " << h << " s";
    else first = e;
    last = e;
  }
  return std::log2(first / last) / std::log2(steps[0] / steps[4]);
}

TEST(NetReference, ConvergesWithDefaultIterationsToo) {
  const Truth truth = solved_exactly(false);
  EXPECT_GE(order_by_default<ImplicitEuler>(truth), 0.9);
  EXPECT_GE(order_by_default<TrBdf2>(truth), 1.6);
}

TEST(NetReference, PressedOnAPlane) {
  const Truth truth = solved_exactly(true);
  auto net = std::make_unique<NetSmall<TrBdf2>>(1e-3, true);
  net->moved();
  EXPECT_GE(net->out.net.num_contacts, 1u);
  for (const bool tight : {true, false}) {
    const Real e = error<TrBdf2>(1e-3, true, tight, truth), e_2 = error<TrBdf2>(5e-4, true, tight, truth);
    std::printf("pressed, %s iterations: %.2e, %.2e m of a deformation of %.2e m\n",
                tight ? "many" : "default", e, e_2, truth.deformation);
    EXPECT_LE(e, 0.05 * truth.deformation);
    EXPECT_LE(e_2, 0.02 * truth.deformation);
    EXPECT_LE(e_2, 0.6 * e);
  }
}

}  // namespace
}  // namespace godobject::test_net_reference
