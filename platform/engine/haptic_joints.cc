// Compositions: articulated tools that follow poses and show forces; bare, and with stops and imposed joints.
#include "platform/engine/tool.h"

namespace godobject {

void add_haptic_joints(std::vector<CompositionRow>& table) {
  add_tool<HapticTool, 8, BareJoints>(table, "haptic-joints", DeviceKind::impedance);
  add_tool<HapticTool, 8, JointsWithAll>(table, "haptic-joints-stops-imposed", DeviceKind::impedance);
}

}  // namespace godobject
