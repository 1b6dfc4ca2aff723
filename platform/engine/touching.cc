// Compositions: many bodies that touch each other and obstacles; free, some following the device, or held by it.
#include "platform/engine/tool.h"

namespace godobject {

namespace {

template <class Device, class Coupling, class Feedback>
using Pile = Tool<ImplicitEuler, 64, Device, Coupling, Feedback, None, PileContacts>;

}  // namespace

void add_touching(std::vector<CompositionRow>& table) {
  table.push_back(row<Pile<None, None, None>>("free-touching", DeviceKind::non_haptic));
  table.push_back(
      row<Pile<PoseDevice, DampedSpring, LimitedFeedback>>("haptic-touching", DeviceKind::impedance));
  table.push_back(
      row<Pile<HoldingDevice, DampedSpring, LimitedFeedback>>("holding-touching", DeviceKind::impedance));
}

}  // namespace godobject
