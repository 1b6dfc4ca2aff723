#include "platform/engine/joint_params.h"

#include <algorithm>
#include <cmath>

#include "core/joint/list.h"

namespace godobject {
namespace {

std::size_t index_of(std::span<const BodyConfig> bodies, const std::string& name) {
  const auto found = std::ranges::find(bodies, name, &BodyConfig::name);
  return found == bodies.end() ? world : static_cast<std::size_t>(found - bodies.begin());
}

JointFrames frames_at_start(std::span<const BodyConfig> bodies, const JointConfig& joint) {
  const std::size_t parent = index_of(bodies, joint.parent);
  const Pose X_WP = parent == world ? Pose{} : bodies[parent].X_WB;
  const Pose& X_WC = bodies[index_of(bodies, joint.child)].X_WB;
  return {.R_WP = (X_WP.q * joint.X_BP.q).toRotationMatrix(),
          .R_WC = (X_WC.q * joint.X_BC.q).toRotationMatrix(),
          .d_W = X_WC.p + X_WC.q * joint.X_BC.p - X_WP.p - X_WP.q * joint.X_BP.p};
}

double angle_between(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

double angular_gap(JointKind kind, const JointFrames& X) {
  const Mat3 &P = X.R_WP, &C = X.R_WC;
  switch (kind) {
    case JointKind::hinge:
    case JointKind::cylindrical: return angle_between(P.col(2), C.col(2));
    case JointKind::universal: return std::abs(pi / 2 - angle_between(P.col(0), C.col(1)));
    case JointKind::fixed:
    case JointKind::slider: return Eigen::AngleAxis<Real>(P.transpose() * C).angle();
    default: return 0;
  }
}

}  // namespace

JointParams joint_params(std::span<const BodyConfig> bodies, const JointConfig& joint) {
  return {.kind = joint.kind,
          .parent = index_of(bodies, joint.parent),
          .P = joint_frame(joint.X_BP),
          .C = joint_frame(joint.X_BC)};
}

JointGap gap_at_start(std::span<const BodyConfig> bodies, const JointConfig& joint) {
  const JointFrames X = frames_at_start(bodies, joint);
  JointGap gap{.m = 0, .rad = angular_gap(joint.kind, X)};
  with_joint(joint.kind, [&](auto kind) { gap.m = decltype(kind)::motion(X).e_v.norm(); });
  return gap;
}

JointCoordinates coordinates_at_start(std::span<const BodyConfig> bodies, const JointConfig& joint) {
  const JointFrames X = frames_at_start(bodies, joint);
  JointCoordinates q = JointCoordinates::Zero();
  with_joint(joint.kind, [&](auto kind) {
    using Kind = decltype(kind);
    if constexpr (requires { Kind::coordinates(X); }) q = Kind::coordinates(X);
  });
  return q;
}

}  // namespace godobject
