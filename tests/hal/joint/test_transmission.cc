// Transmissions that couple joints, by power and by the numbers of a wristed instrument.
#include "hal/joint/transmission.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <ostream>
#include <random>

namespace godobject::test_transmission {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

std::vector<DeviceJoint> joints_of_driver() {
  return {{.name = "insertion", .kind = DeviceJointKind::slider},
          {.name = "roll"},
          {.name = "pitch"},
          {.name = "yaw"},
          {.name = "jaw"}};
}
/// Discs of a needle driver, in an order of their own.
TransmissionParams discs() {
  return {.joints = {"roll", "pitch", "yaw", "jaw"},
          .joint_per_actuator = {
              {-1.5632, 0, 0, 0}, {0, 1.0186, 0, 0}, {0, -0.8306, 0.6089, 0.6089}, {0, 0, -1.2177, 1.2177}}};
}

JointVector vector_of(std::initializer_list<double> numbers) {
  JointVector x(static_cast<Eigen::Index>(numbers.size()));
  std::ranges::copy(numbers, x.begin());
  return x;
}

TEST(Transmission, MapsCoordinatesAndTorquesOfANeedleDriver) {
  const TransmissionParams of_discs = discs();
  const Transmission transmission({&of_discs, 1}, joints_of_driver());
  const JointVector q = transmission.joints(vector_of({0.1, 0.2, -0.3, 0.4, 0.5}));
  EXPECT_NEAR(q(0), 0.1, 1e-15);  // outside of the group
  EXPECT_NEAR(q(1), -1.5632 * 0.2, 1e-15);
  EXPECT_NEAR(q(2), 1.0186 * -0.3, 1e-15);
  EXPECT_NEAR(q(3), -0.8306 * -0.3 + 0.6089 * (0.4 + 0.5), 1e-15);
  EXPECT_NEAR(q(4), 1.2177 * (0.5 - 0.4), 1e-15);
  // a torque about yaw is held by three discs, one about the jaws by two
  const JointVector of_yaw = transmission.actuator_torques(vector_of({0, 0, 0, 0.1, 0}));
  EXPECT_LT((of_yaw - vector_of({0, 0, -0.08306, 0.06089, 0.06089})).norm(), 1e-15);
  const JointVector of_jaw = transmission.actuator_torques(vector_of({2, 0, 0, 0, 0.1}));
  EXPECT_LT((of_jaw - vector_of({2, 0, 0, -0.12177, 0.12177})).norm(), 1e-15);
}

TEST(Transmission, ConservesPowerAndInverts) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-2, 2);
  for (int round = 0; round < 200; ++round) {
    TransmissionParams group{.joints = {"jaw", "insertion", "pitch"}};
    for (int i = 0; i < 3; ++i)
      group.joint_per_actuator.push_back({uniform(random), uniform(random), uniform(random)});
    const std::vector<DeviceJoint> joints = joints_of_driver();
    if (!validate({&group, 1}, joints).empty()) continue;
    const Transmission transmission({&group, 1}, joints);
    JointVector a(5), tau(5);
    for (Eigen::Index i = 0; i < 5; ++i) a(i) = uniform(random), tau(i) = uniform(random);
    const JointVector q = transmission.joints(a), tau_a = transmission.actuator_torques(tau);
    EXPECT_NEAR(tau_a.dot(a), tau.dot(q), 1e-12);
    EXPECT_LT((transmission.actuators(q) - a).norm(), 1e-7);
    EXPECT_LT((transmission.joint_torques(tau_a) - tau).norm(), 1e-7);
    const Eigen::MatrixXd K = Eigen::MatrixXd::Identity(5, 5);
    EXPECT_NEAR(a.dot(transmission.at_actuators(K) * a), q.squaredNorm(), 1e-12);  // energy of a stiffness
  }
}

TEST(Transmission, NoneLeavesEveryBitAlone) {
  const Transmission none;
  const JointVector x = vector_of({-0.0, 1e-310, 0.1});
  const JointVector y = none.joints(x), z = none.actuator_torques(x);
  EXPECT_TRUE(std::signbit(y(0)) && std::signbit(z(0)));
  EXPECT_EQ(y, x);
  EXPECT_EQ(none.actuators(x), x);
}

struct Broken {
  const char* says;
  void (*break_it)(TransmissionParams&);
};
void PrintTo(const Broken& one, std::ostream* out) { *out << one.says; }

class TransmissionErrors : public testing::TestWithParam<Broken> {};

TEST_P(TransmissionErrors, NamesTheRemedy) {
  TransmissionParams group = discs();
  ASSERT_THAT(validate({&group, 1}, joints_of_driver()), IsEmpty());
  GetParam().break_it(group);
  EXPECT_THAT(validate({&group, 1}, joints_of_driver()), Contains(HasSubstr(GetParam().says)));
}

const Broken broken[] = {
    {"at least one joint", [](TransmissionParams& t) { t.joints.clear(); }},
    {"no joint 'wrist'", [](TransmissionParams& t) { t.joints[1] = "wrist"; }},
    {"'roll' is named twice", [](TransmissionParams& t) { t.joints[1] = "roll"; }},
    {"must have 4 rows of 4 numbers", [](TransmissionParams& t) { t.joint_per_actuator.pop_back(); }},
    {"rows of 4 numbers", [](TransmissionParams& t) { t.joint_per_actuator[2].push_back(1); }},
    {"must be finite",
     [](TransmissionParams& t) { t.joint_per_actuator[0][0] = std::numeric_limits<double>::infinity(); }},
    {"is singular",
     [](TransmissionParams& t) {
       t.joint_per_actuator[3] = {0, 0, 1, 1};
       t.joint_per_actuator[2] = {0, 0, 2, 2};
     }},
    {"singular: some motion", [](TransmissionParams& t) { t.joint_per_actuator[0][0] = 0; }},
};

INSTANTIATE_TEST_SUITE_P(Each, TransmissionErrors, testing::ValuesIn(broken));

}  // namespace
}  // namespace godobject::test_transmission
