#include "tests/study/joint/scene.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "tests/oracle/scenes.h"
#include "tests/oracle/target.h"

namespace godobject::study {
namespace {

using oracle::Body;
using oracle::Case;
using oracle::Joint;
using oracle::JointType;
using oracle::Quaterniond;
using oracle::RigidState;
using oracle::Vector3d;

constexpr double degree = std::numbers::pi / 180;

struct Signal {
  double value = 0, rate = 0;
};

/// Returns offset + amplitude sin(2 pi frequency t + phase).
Signal sine(double t, double offset, double amplitude, double frequency_Hz, double phase) {
  const double w = 2 * std::numbers::pi * frequency_Hz;
  return {offset + amplitude * std::sin(w * t + phase), amplitude * w * std::cos(w * t + phase)};
}

/// Rotates the frame about one of its own axes.
RigidState turned(const RigidState& X, const Vector3d& axis, const Signal& angle) {
  RigidState Y = X;
  Y.w += X.q * (angle.rate * axis);
  Y.q = X.q * Quaterniond(Eigen::AngleAxisd(angle.value, axis));
  return Y;
}

/// Moves the origin to a point fixed on the frame, or sliding on it.
RigidState moved(const RigidState& X, const Vector3d& p_X, const Vector3d& v_X = Vector3d::Zero()) {
  RigidState Y = X;
  Y.p += X.q * p_X;
  Y.v += X.w.cross(X.q * p_X) + X.q * v_X;
  return Y;
}

constexpr double hinge_z = -0.175, jaw_length = 0.01;  // m, from the centres of tube and jaw

/// Returns the target of a body of the device of S3: trocar, tube, jaws.
RigidState s3_device(std::size_t body, double t, double amplitude) {
  const Vector3d X = Vector3d::UnitX(), Y = Vector3d::UnitY(), Z = Vector3d::UnitZ();
  const auto sine_of = [&](double size, double frequency_Hz, double phase) {
    return sine(t, 0, amplitude * size, frequency_Hz, phase);
  };
  RigidState trocar =
      turned(turned(RigidState{}, X, sine_of(30 * degree, 1, 0)), Y, sine_of(30 * degree, 0.8, 0.9));
  if (body == 0) return trocar;
  const Signal slide = sine_of(0.04, 0.5, 0.4);
  RigidState tube =
      turned(moved(trocar, (0.025 + slide.value) * Z, slide.rate * Z), Z, sine_of(60 * degree, 0.7, 1.3));
  if (body == 1) return tube;
  const double side = body == 2 ? 1 : -1;
  const Signal opening =
      sine(t, side * 20 * degree, side * amplitude * 20 * degree, 1.2, -std::numbers::pi / 2);
  return moved(turned(moved(tube, hinge_z * Z), X, opening), -jaw_length * Z);
}

/// Returns the motion at another rate.
template <class F>
std::shared_ptr<const oracle::Target> target_of(F state_at, double rate) {
  return std::make_shared<oracle::FunctionTarget>([state_at, rate](double t) {
    RigidState D = state_at(rate * t);
    D.v *= rate;
    D.w *= rate;
    return D;
  });
}

/// Returns the target of S1, about the origin.
auto s1_device(double amplitude) {
  return [amplitude](double t) {
    RigidState D = oracle::scene_s1_target(t);
    D.p *= amplitude;
    D.v *= amplitude;
    return D;
  };
}

/// Makes a body at the device, coupled with damping ratio 1.4, for rotation with the largest moment of
/// inertia.
Body coupled_body(const char* name, double m, const Vector3d& moments, double k, double k_r,
                  std::shared_ptr<const oracle::Target> target) {
  Body body;
  body.name = name;
  body.m = m;
  body.I_B = moments.asDiagonal();
  body.start = target->at(0);
  body.coupling = {.k_t = k,
                   .g_t = 1.4 * std::sqrt(m * k),
                   .k_r = k_r,
                   .g_r = 1.4 * std::sqrt(k_r * moments.maxCoeff()),
                   .target = std::move(target)};
  return body;
}

Joint joint(const char* name, JointType type, std::optional<std::size_t> parent, std::size_t child,
            const Vector3d& anchor_P, const Vector3d& anchor_C) {
  Joint j;
  j.name = name;
  j.type = type;
  j.parent = parent;
  j.child = child;
  j.anchor_P = anchor_P;
  j.anchor_C = anchor_C;
  return j;
}

}  // namespace

Case scene_s1(Motion motion) {
  Case scene = oracle::scene_s1();
  Body& tool = scene.bodies.front();
  tool.coupling->target = target_of(s1_device(motion.amplitude), motion.rate);
  tool.start = tool.coupling->target->at(0);
  return scene;
}

Case scene_s3(Motion motion) {
  const auto device = [&](std::size_t body) {
    return target_of([=](double t) { return s3_device(body, t, motion.amplitude); }, motion.rate);
  };
  const Vector3d jaw(1.7e-7, 1.7e-7, 4e-8), none = Vector3d::Zero(), hinge(0, 0, hinge_z),
                                            on_jaw(0, 0, jaw_length);
  Case scene;
  scene.bodies = {coupled_body("trocar", 0.05, Vector3d::Constant(1e-5), 1000, 0.5, device(0)),
                  coupled_body("tube", 0.08, {8.1667e-4, 8.1667e-4, 1e-6}, 1000, 1, device(1)),
                  coupled_body("left", 0.005, jaw, 200, 0.02, device(2)),
                  coupled_body("right", 0.005, jaw, 200, 0.02, device(3))};
  scene.joints = {joint("pivot", JointType::universal, std::nullopt, 0, none, none),
                  joint("sleeve", JointType::cylindrical, 0, 1, none, none),
                  joint("left_hinge", JointType::hinge, 1, 2, hinge, on_jaw),
                  joint("right_hinge", JointType::hinge, 1, 3, hinge, on_jaw)};
  scene.joints[0].axis_P = Vector3d::UnitX();
  scene.joints[0].axis_C = Vector3d::UnitY();
  for (std::size_t i : {2u, 3u}) scene.joints[i].axis_P = Vector3d::UnitX();
  return scene;
}

Case stiffened(Case problem, double factor) {
  for (Body& body : problem.bodies) {
    oracle::Coupling& c = *body.coupling;
    c.k_t *= factor;
    c.k_r *= factor;
    c.g_t *= std::sqrt(factor);
    c.g_r *= std::sqrt(factor);
  }
  return problem;
}

Case scene_s5(std::size_t num_links) {
  constexpr double length = 0.1;
  const Quaterniond q(Eigen::AngleAxisd(135 * degree, Vector3d::UnitY()));
  const Vector3d end(0, 0, length / 2);
  Case scene;
  scene.gravity = {0, 0, -9.81};
  for (std::size_t i = 0; i < num_links; ++i) {
    Body link;
    link.name = "link" + std::to_string(i);
    link.m = 0.1;
    link.I_B = Vector3d(8.333e-5, 8.333e-5, 5e-6).asDiagonal();
    link.start.q = q;
    link.start.p = q * Vector3d(0, 0, length * (static_cast<double>(i) + 0.5));
    scene.bodies.push_back(link);
    if (i == 0)
      scene.joints.push_back(joint("hook", JointType::ball, std::nullopt, 0, Vector3d::Zero(), -end));
    else scene.joints.push_back(joint("pin", JointType::ball, i - 1, i, end, -end));
  }
  return scene;
}

Case scene_pair(JointType type, Motion motion) {
  const double a = motion.amplitude;
  const auto first = s1_device(a);
  const auto second = [=](double t) {
    const Vector3d axis = Vector3d(1, 2, -2) / 3;
    const Signal slide = sine(t, 0.1, 0.02 * a, 0.9, 0);
    return turned(moved(first(t), slide.value * axis, slide.rate * axis), axis, sine(t, 0, 0.5 * a, 1.1, 0));
  };
  const Vector3d moments(3.4667e-4, 3.4667e-4, 2.6667e-5), on_first(0, 0, 0.05);
  Case scene;
  scene.bodies = {coupled_body("first", 0.1, moments, 1000, 1, target_of(first, motion.rate)),
                  coupled_body("second", 0.1, moments, 1000, 1, target_of(second, motion.rate))};
  // the joint starts without violation, at coordinate zero
  scene.bodies[1].start = moved(scene.bodies[0].start, 2 * on_first);
  scene.joints = {joint("joint", type, 0, 1, on_first, -on_first)};
  if (type == JointType::universal) {
    scene.joints[0].axis_P = Vector3d::UnitX();
    scene.joints[0].axis_C = Vector3d::UnitY();
  }
  return scene;
}

}  // namespace godobject::study
