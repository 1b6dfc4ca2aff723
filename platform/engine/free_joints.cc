// Compositions: articulated bodies without a device, with and without stops; and long chains.
#include "platform/engine/tool.h"

namespace godobject {

void add_free_joints(std::vector<CompositionRow>& table) {
  add_tool<FreeTool, 8, BareJoints>(table, "free-joints", DeviceKind::non_haptic);
  add_tool<FreeTool, 8, JointsWithStops>(table, "free-joints-stops", DeviceKind::non_haptic);
  add_tool<FreeTool, 256, BareJoints>(table, "free-joints", DeviceKind::non_haptic);
}

}  // namespace godobject
