// Compositions: articulated tools that follow poses, nothing back; bare, and with stops and imposed joints.
#include "platform/engine/tool.h"

namespace godobject {

void add_pose_joints(std::vector<CompositionRow>& table) {
  add_tool<PoseTool, 8, BareJoints>(table, "pose-joints", DeviceKind::non_haptic);
  add_tool<PoseTool, 8, JointsWithAll>(table, "pose-joints-stops-imposed", DeviceKind::non_haptic);
}

}  // namespace godobject
