// Compositions: articulated tools with stops that follow poses and show forces.
#include "platform/engine/tool.h"

namespace godobject {

void add_haptic_stops(std::vector<CompositionRow>& table) {
  add_tool<HapticTool, 8, JointsWithStops>(table, "haptic-joints-stops", DeviceKind::impedance);
}

}  // namespace godobject
