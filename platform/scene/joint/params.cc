#include "platform/scene/joint/params.h"

#include <algorithm>

#include "platform/scene/joint/kinds.h"

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
