#include "platform/session/record.h"

#include <cmath>

#include "platform/scene/joint/joints.h"

namespace godobject {
namespace {

JointFrames frames_of(const JointParams& joint, const Pose& X_WP, const Pose& X_WC) noexcept {
  const Mat3 R_WP = X_WP.q.toRotationMatrix(), R_WC = X_WC.q.toRotationMatrix();
  return {.R_WP = R_WP * joint.P.R,
          .R_WC = R_WC * joint.C.R,
          .d_W = (X_WC.p + R_WC * joint.C.p) - (X_WP.p + R_WP * joint.P.p)};
}

}  // namespace

JointCoordinatesOf::JointCoordinatesOf(const SceneConfig& scene) {
  for (const JointConfig& joint : scene.joints) {
    joints_.push_back(
        {.params = joint_params(scene.bodies, joint), .child = body_named(scene, joint.child).value()});
    size_ += num_coordinates(joint.kind);
  }
}

void JointCoordinatesOf::read(std::span<const BodyView> bodies, std::span<double> q) const noexcept {
  std::size_t next = 0;
  for (const Joint& joint : joints_) {
    const std::size_t n = num_coordinates(joint.params.kind);
    const Pose X_WP = joint.params.parent == world ? Pose{} : bodies[joint.params.parent].X_WB;
    const JointFrames X = frames_of(joint.params, X_WP, bodies[joint.child].X_WB);
    with_joint(joint.params.kind, [&](auto kind) {
      if constexpr (requires { kind.coordinates(X); }) {
        const JointCoordinates now = kind.coordinates(X);
        for (std::size_t i = 0; i < n; ++i) {
          double& before = q[next + i];
          const double x = now[static_cast<Eigen::Index>(i)];
          before = is_turn(joint.params.kind, i) ? x + 2 * pi * std::round((before - x) / (2 * pi)) : x;
        }
      }
    });
    next += n;
  }
}

}  // namespace godobject
