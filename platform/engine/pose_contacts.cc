// Compositions: tools that follow poses and touch obstacles, nothing back; one body, and articulated with all.
#include "platform/engine/tool.h"

namespace godobject {

void add_pose_contacts(std::vector<CompositionRow>& table) {
  add_tool<PoseTool, 1, BareJoints, ToolContacts>(table, "pose-contacts", DeviceKind::non_haptic);
  add_tool<PoseTool, 8, JointsWithAll, ToolContacts>(table, "pose-joints-stops-imposed-contacts",
                                                     DeviceKind::non_haptic);
}

}  // namespace godobject
