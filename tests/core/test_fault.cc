// A number that is not finite neither enters nor leaves the core.
#include "core/fault.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <vector>

#include "tests/core/one_body.h"

namespace godobject::test_fault {
namespace {

constexpr Real inf = std::numeric_limits<Real>::infinity();
constexpr Real nan = std::numeric_limits<Real>::quiet_NaN();

using Numbers = std::vector<std::reference_wrapper<Real>>;

void append(Numbers& all, Vec3& a) { all.insert(all.end(), {a.x(), a.y(), a.z()}); }
void append(Numbers& all, Quat& q) { all.insert(all.end(), {q.w(), q.x(), q.y(), q.z()}); }
void append(Numbers& all, Pose& X) { append(all, X.p), append(all, X.q); }
void append(Numbers& all, Twist& V) { append(all, V.w), append(all, V.v); }
void append(Numbers& all, Wrench& F) { append(all, F.tau), append(all, F.f); }
void append(Numbers& all, PoseDevice::Input& in) { append(all, in.target.X_WD), append(all, in.target.V_WD); }
void append(Numbers& all, RelativeDevice::Input& in) { append(all, in.dp_W), append(all, in.dphi_W); }
void append(Numbers& all, AdmittanceDevice::Input& in) { append(all, in.F_WB); }
template <int slot>
void append(Numbers&, Absent<slot>&) {}
void append(Numbers& all, TrBdf2::Memory& x) { append(all, x.a_W), append(all, x.alpha_B); }

void move(PoseDevice::Input& in, Real t) {
  const Real a = 0.3 * std::sin(3 * t);
  in.target.X_WD = {.p = 0.1 * Vec3(std::sin(2 * t), 1, std::cos(t)),
                    .q = Quat(std::cos(a), 0, std::sin(a), 0)};
  in.target.V_WD = {.w = Vec3(0, 1.8 * std::cos(3 * t), 0),
                    .v = 0.1 * Vec3(2 * std::cos(2 * t), 0, -std::sin(t))};
}
void move(RelativeDevice::Input& in, Real t) {
  in.dp_W = 1e-4 * Vec3(std::sin(t), 1, 0);
  in.dphi_W = 1e-3 * Vec3(0, std::cos(t), 1);
}
void move(AdmittanceDevice::Input& in, Real t) {
  in.F_WB = {.tau = 0.1 * Vec3(std::sin(t), 1, 0), .f = Vec3(0, std::cos(t), 2)};
}

template <class DevicePart, class IntegratorPart>
struct Kind {
  using Device = DevicePart;
  using Integrator = IntegratorPart;
};

template <class K>
class FaultOf : public ::testing::Test {
 protected:
  using S = OneBody<typename K::Integrator, typename K::Device, DampedSpring, LimitedFeedback>;

  FaultOf() {
    run_.constants().body = rigid_body(0.2, Vec3(2e-3, 1e-3, 1.5e-3).asDiagonal());
    run_.constants().coupling = {.k = 2000, .g = 30, .k_r = 4, .g_r = 0.15};
    run_.constants().feedback.gains = {.k = 1000, .g = 2, .k_r = 2, .g_r = 0.05};
    run_.constants().device.rise = 0.05;
    run(400);
    EXPECT_FALSE(any(run_.out.fault));
    EXPECT_GT(shown().f.norm(), 0);
  }

  void run(int steps) {
    for (int n = 0; n < steps; ++n, ++n_) {
      move(run_.device(), n_ * run_.par.h);
      run_.step();
    }
  }
  const Wrench& shown() const { return run_.out.bodies[0].feedback.F_D; }

  std::uint64_t hash_without_shown() const {
    State<S> x = run_.x;
    x.bodies[0].feedback.F_D = {};
    return state_hash(run_.par, x);
  }

  bool output_is_finite() const {
    const BodyOutput<S>& out = run_.out.bodies[0];
    return godobject::is_finite(sum(out.X_WB) + sum(out.V_WB) + sum(out.feedback.F_D));
  }

  /// Steps with the given input: rejected with `fault`, and the hand is released within the rate limit.
  void expect_refused(Fault fault) {
    const std::uint64_t hash = hash_without_shown();
    const Wrench before = shown();
    const FeedbackParams& limits = run_.constants().feedback;
    run_.step();
    EXPECT_TRUE(has(run_.out.fault, fault)) << std::uint32_t(run_.out.fault);
    EXPECT_EQ(hash_without_shown(), hash);
    EXPECT_TRUE(output_is_finite());
    EXPECT_LE((shown().f - before.f).norm(), run_.par.h * limits.max_force_rate * (1 + 1e-12));
    EXPECT_LE((shown().tau - before.tau).norm(), run_.par.h * limits.max_torque_rate * (1 + 1e-12));
    run_.step(21);  // 10 N at 500 N/s, 0.5 N m at 25 N m/s
    EXPECT_EQ(hash_without_shown(), hash);
    EXPECT_EQ(shown().f, Vec3(Vec3::Zero()));
    EXPECT_EQ(shown().tau, Vec3(Vec3::Zero()));
  }

  /// Goes on as if the faulty steps had not been: equal to a run without them, but for the shown wrench.
  void expect_recovered() {
    run(300);
    EXPECT_FALSE(any(run_.out.fault));
    EXPECT_TRUE(output_is_finite());
    EXPECT_GT(shown().f.norm(), 0);
  }

  int n_ = 0;
  Running<S> run_;
};

using Kinds = ::testing::Types<Kind<PoseDevice, ImplicitEuler>, Kind<PoseDevice, TrBdf2>,
                               Kind<RelativeDevice, ImplicitEuler>, Kind<RelativeDevice, TrBdf2>,
                               Kind<AdmittanceDevice, ImplicitEuler>, Kind<AdmittanceDevice, TrBdf2>>;
TYPED_TEST_SUITE(FaultOf, Kinds);

TYPED_TEST(FaultOf, EachNumberOfTheInput) {
  Numbers numbers;
  append(numbers, this->run_.device());
  for (std::size_t i = 0; i < numbers.size(); ++i)
    for (const Real bad : {nan, -nan, inf, -inf}) {
      SCOPED_TRACE(::testing::Message() << bad << " in number " << i << " of the input");
      numbers[i].get() = bad;
      this->expect_refused(Fault::input_not_finite);
      this->expect_recovered();
    }
}

TYPED_TEST(FaultOf, TwoInfinitiesThatWouldCancel) {
  Numbers numbers;
  append(numbers, this->run_.device());
  numbers[0].get() = inf;
  numbers[1].get() = -inf;
  this->expect_refused(Fault::input_not_finite);
  this->expect_recovered();
}

TYPED_TEST(FaultOf, InvalidSampleMayHoldAnything) {
  Numbers numbers;
  append(numbers, this->run_.device());
  for (Real& number : numbers) number = nan;
  this->run_.device().valid = false;
  this->run_.step(10);
  EXPECT_FALSE(any(this->run_.out.fault));
  EXPECT_TRUE(has(this->run_.out.limited, Limited::held));
  EXPECT_TRUE(this->output_is_finite());
  this->run_.device().valid = true;
  this->expect_recovered();
}

/// Inputs that are finite but drive the arithmetic to infinity, or nearly.
TYPED_TEST(FaultOf, HugeInputsLeaveAsFiniteNumbers) {
  Numbers numbers;
  append(numbers, this->run_.device());
  for (std::size_t i = 0; i < numbers.size(); ++i)
    for (const Real huge : {1e100, 1e150, 1e160, 1e200, 1e250, 1e300, 1e302, 1e304, 1e306, 1e308})
      for (const Real sign : {1.0, -1.0}) {
        SCOPED_TRACE(::testing::Message() << sign * huge << " in number " << i << " of the input");
        const auto before = this->run_.x;
        numbers[i].get() = sign * huge;
        for (int n = 0; n < 5; ++n) {
          this->run_.step();
          ASSERT_TRUE(this->output_is_finite());
          ASSERT_TRUE(is_finite(this->run_.body()));
        }
        this->run_.x = before;
        this->expect_recovered();
      }
}

TYPED_TEST(FaultOf, NanPlantedInTheMotion) {
  const auto good = this->run_.x;
  auto& body = this->run_.x.bodies[0];
  Numbers numbers;
  append(numbers, body.x.X_WB);
  append(numbers, body.x.v_W);
  append(numbers, body.x.w_B);
  append(numbers, body.memory);
  for (std::size_t i = 0; i < numbers.size(); ++i)
    for (const Real bad : {nan, inf}) {
      SCOPED_TRACE(::testing::Message() << bad << " in number " << i << " of the state");
      numbers[i].get() = bad;
      this->expect_refused(Fault::state_not_finite);
      this->run_.x = good;
      this->expect_recovered();
    }
}

TYPED_TEST(FaultOf, NanPlantedInTheRestOfTheState) {
  const auto good = this->run_.x;
  auto& body = this->run_.x.bodies[0];
  Numbers numbers;
  append(numbers, body.coupling.phi_B);
  append(numbers, body.device.last.X_WD);
  append(numbers, body.device.last.V_WD);
  append(numbers, body.feedback.F_D);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    SCOPED_TRACE(::testing::Message() << "number " << i << " of the rest of the state");
    numbers[i].get() = nan;
    for (int n = 0; n < 5; ++n) {
      this->run_.step();
      EXPECT_TRUE(this->output_is_finite());
    }
    this->run_.x = good;
    this->expect_recovered();
  }
}

TYPED_TEST(FaultOf, FaultsLeaveNoTrace) {
  auto undisturbed = this->run_;
  Numbers numbers;
  append(numbers, this->run_.device());
  numbers.back().get() = nan;
  this->run_.step(7);
  for (int n = 0; n < 200; ++n) {
    move(this->run_.device(), n * 1e-3);
    move(undisturbed.device(), n * 1e-3);
    this->run_.step();
    undisturbed.step();
  }
  EXPECT_EQ(this->run_.hash(), undisturbed.hash());
}

TEST(FaultOfQuaternion, OffUnitLengthIsRefused) {
  for (const Real length : {0.0, 0.5, 1 - 1e-5, 1 + 1e-5, 2.0}) {
    Running<OneBody<ImplicitEuler>> run;
    run.step();
    const std::uint64_t hash = run.hash();
    run.device().target.X_WD.q.coeffs() = length * Quat(0.6, 0, 0.8, 0).coeffs();
    run.step();
    EXPECT_EQ(run.out.fault, Fault::input_not_unit) << length;
    EXPECT_EQ(run.hash(), hash);
  }
  for (const Real length : {1 - 0.9e-6, 1 + 0.9e-6}) {
    Running<OneBody<ImplicitEuler>> run;
    run.device().target.X_WD.q.coeffs() = length * Quat(0.6, 0, 0.8, 0).coeffs();
    run.step();
    EXPECT_EQ(run.out.fault, Fault::none) << length;
    EXPECT_NEAR(run.x.bodies[0].device.last.X_WD.q.norm(), 1, 2e-12);  // one Newton step
  }
}

TEST(Fault, InTheFirstStepLeavesThePoseWhereTheBodyWasPut) {
  Running<OneBody<TrBdf2>> run;
  place(run.x, 0, {.X_WB = {.p = Vec3(1, 2, 3), .q = Quat::Identity()}, .V_WB = {}});
  run.device().target.X_WD.p.x() = std::numeric_limits<Real>::quiet_NaN();
  run.step();
  EXPECT_EQ(run.out.fault, Fault::input_not_finite);
  EXPECT_EQ(run.out.bodies[0].X_WB.p, Vec3(1, 2, 3));
}

TEST(Fault, AnIncrementOfMoreThanHalfATurnIsRefused) {
  Running<OneBody<TrBdf2, RelativeDevice>> run;
  run.device().dphi_W = Vec3(0, 0, 15);
  run.step();
  EXPECT_EQ(run.out.fault, Fault::input_not_unit);
}

TEST(Validate, RefusesAnAnisotropyThatIsTooSmall) {
  Running<OneBody<TrBdf2>> run;
  run.constants().body = rigid_body(1, Vec3(1e-5, 0.5, 1).asDiagonal());
  EXPECT_EQ(validate(run.par), Invalid::nothing);
  run.constants().body.anisotropy = 1;
  EXPECT_EQ(validate(run.par), Invalid::anisotropy_too_small);
}

}  // namespace
}  // namespace godobject::test_fault
