// Compositions: articulated tools that follow poses, nothing back; bare, and with stops and imposed joints.
#include "sim/engine_of.h"

namespace godobject {
namespace {

template <class I, std::size_t N>
struct Tool {
  static constexpr std::size_t max_bodies = N;
  using Integrator = I;
  using Device = PoseDevice;
  using Joints = TreeJoints<>;
  using Coupling = DampedSpring;
  using Feedback = None;
};

template <class I, std::size_t N>
struct ToolWithAll {
  static constexpr std::size_t max_bodies = N;
  using Integrator = I;
  using Device = PoseDevice;
  using Joints = TreeJoints<JointStops, ImposedJoints>;
  using Coupling = DampedSpring;
  using Feedback = None;
};

}  // namespace

void add_pose_joints(std::vector<CompositionRow>& table) {
  add_both<Tool, 8>(table, "pose-joints", DeviceKind::non_haptic);
  add_both<ToolWithAll, 8>(table, "pose-joints-stops-imposed", DeviceKind::non_haptic);
}

}  // namespace godobject
