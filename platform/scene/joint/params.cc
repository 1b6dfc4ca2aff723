#include "platform/scene/joint/joints.h"

#include <algorithm>
#include <vector>

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

void close_gaps(std::span<BodyConfig> bodies, std::span<const JointConfig> joints) {
  const std::vector<BodyConfig> placed(bodies.begin(), bodies.end());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const auto joint = std::ranges::find(joints, bodies[i].name, &JointConfig::child);
    if (joint == joints.end()) continue;
    Pose& X = bodies[i].X_WB;
    const std::size_t parent = index_of(bodies, joint->parent);
    if (parent < i) {
      // moves with its parent
      const Pose &from = placed[parent].X_WB, &to = bodies[parent].X_WB;
      if (from.p != to.p || from.q.coeffs() != to.q.coeffs()) {
        const Quat turn = (to.q * from.q.conjugate()).normalized();
        X = {.p = to.p + turn * (X.p - from.p), .q = (turn * X.q).normalized()};
      }
    }
    if (!is_apart(gap_at_start(bodies, *joint))) continue;
    const JointFrames found = frames_at_start(bodies, *joint);
    with_joint(joint->kind, [&](auto kind) {
      using Kind = decltype(kind);
      JointFrames held = found;  // frame of the parent at the child's coordinates
      if constexpr (requires { Kind::coordinates(found); }) held = Kind::at(found, Kind::coordinates(found));
      const Quat turn(Mat3(held.R_WP * found.R_WC.transpose()));
      const Vec3 anchor = X.p + X.q * joint->X_BC.p - held.d_W;
      if (!is_ball(joint->kind)) X.q = (turn * X.q).normalized();
      X.p = anchor - X.q * joint->X_BC.p;
    });
  }
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
