// Compositions: tools that follow poses, touch obstacles and show forces; one body, and articulated with all.
#include "platform/engine/tool.h"

namespace godobject {

void add_haptic_contacts(std::vector<CompositionRow>& table) {
  add_tool<HapticTool, 1, BareJoints, ToolContacts>(table, "haptic-contacts", DeviceKind::impedance);
  add_tool<HapticTool, 8, JointsWithAll, ToolContacts>(table, "haptic-joints-stops-imposed-contacts",
                                                       DeviceKind::impedance);
}

}  // namespace godobject
