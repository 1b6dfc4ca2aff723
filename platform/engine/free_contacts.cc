// Compositions: bodies without a device that touch obstacles; one, and articulated with stops.
#include "platform/engine/tool.h"

namespace godobject {

void add_free_contacts(std::vector<CompositionRow>& table) {
  add_tool<FreeTool, 1, BareJoints, ToolContacts>(table, "free-contacts", DeviceKind::non_haptic);
  add_tool<FreeTool, 8, JointsWithStops, ToolContacts>(table, "free-joints-stops-contacts",
                                                       DeviceKind::non_haptic);
}

}  // namespace godobject
