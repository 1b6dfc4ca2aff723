// Order of both integrators for a gripper that holds a body and is moved, without impact, slip or separation.
#include <gtest/gtest.h>

#include "tests/core/contact/bodies/jointed_pile.h"

namespace godobject::test_order_of_grippers {
namespace {

constexpr Real duration = 0.128;  // s
constexpr Real finest = 1e-3 / 64;

/// So soft that the steps resolve how the brick sways between the jaws.
template <class I>
std::unique_ptr<GripperOf<I>> soft_gripper(Real h) {
  auto grip = std::make_unique<GripperOf<I>>();
  grip->par.h = h;
  set_law(grip->par, {.k = 60, .c = 0.05, .mu = 10, .k_t = 60, .c_t = 0.05});
  return grip;
}

/// Returns the gripper with its body, at rest.
const GripperOf<TrBdf2>& at_rest() {
  static const auto rested = [] {
    auto grip = soft_gripper<TrBdf2>(finest);
    EXPECT_TRUE(grip->run(1));
    return grip;
  }();
  return *rested;
}

struct Moved {
  std::vector<Vec3> p;
  int of_first_order = 0;
};

/// Moved by its palm, which begins at rest.
template <class I>
Moved moved(Real h) {
  const auto grip = soft_gripper<I>(h);
  const auto& rested = at_rest();
  grip->x.contacts = rested.x.contacts;
  for (std::size_t i = 0; i < grip->par.num_bodies; ++i) {
    grip->x.bodies[i].x.X_WB = rested.x.bodies[i].x.X_WB;
    grip->x.bodies[i].joint = rested.x.bodies[i].joint;
  }
  Moved end;
  const Vec3 way(0.0004, 0.0002, 0.0003), start(0, 0, GripperOf<I>::height);
  const Real rate = 2 * pi * 6;
  for (long n = 1; n <= std::lround(duration / h); ++n) {
    const Real t = static_cast<Real>(n) * h;
    auto& target = grip->in.devices[GripperOf<I>::palm].target;
    target.X_WD.p = start + way * (1 - std::cos(rate * t));
    target.V_WD.v = way * rate * std::sin(rate * t);
    grip->step();
    EXPECT_EQ(grip->out.fault, Fault::none);
    end.of_first_order += has(grip->out.limited, Limited::first_order) ? 1 : 0;
  }
  end.p = grip->positions();
  return end;
}

/// Errors at 1, 1/2, 1/4 ms against TR-BDF2 at 1/64 ms; the order from the last two.
template <class I>
Real order(const std::vector<Vec3>& exact) {
  std::vector<Real> errors;
  for (const Real h : {1e-3, 5e-4, 2.5e-4}) {
    const Moved end = moved<I>(h);
    Real most = 0;
    for (std::size_t i = 0; i < exact.size(); ++i) most = std::max(most, (end.p[i] - exact[i]).norm());
    errors.push_back(most);
    if (I::order > 1) {
      EXPECT_LE(end.of_first_order, 1) << h;  // the first
    }
  }
  const Real order = std::log2(errors[1] / errors[2]);
  std::printf("%s, a brick held by a gripper: %.1e, %.1e, %.1e m, order %.2f\n", I::name, errors[0],
              errors[1], errors[2], order);
  return order;
}

TEST(OrderOfGrippers, IsThatOfTheIntegrator) {
  const std::vector<Vec3> exact = moved<TrBdf2>(finest).p;
  EXPECT_GT(order<ImplicitEuler>(exact), 0.9);
  EXPECT_GT(order<TrBdf2>(exact), 1.9);
}

}  // namespace
}  // namespace godobject::test_order_of_grippers
