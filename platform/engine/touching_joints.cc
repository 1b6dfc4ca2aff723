// Composition: articulated tools and free bodies that touch each other and obstacles, with all that joints can have.
// One for all such scenes, with and without a device: its templates take minutes to compile.
#include "platform/engine/tool.h"

namespace godobject {

void add_touching_joints(std::vector<CompositionRow>& table) {
  table.push_back(
      row<Tool<ImplicitEuler, 64, PoseDevice, DampedSpring, LimitedFeedback, JointsWithAll, PileContacts>>(
          "haptic-joints-stops-imposed-touching", DeviceKind::impedance));
}

}  // namespace godobject
