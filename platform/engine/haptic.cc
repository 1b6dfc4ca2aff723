// Compositions: tools that follow a pose and show a force.
#include "platform/engine/of.h"

namespace godobject {
namespace {

template <class I, std::size_t N>
struct Haptic {
  static constexpr std::size_t max_bodies = N;
  using Integrator = I;
  using Device = PoseDevice;
  using Coupling = DampedSpring;
  using Joints = None;
  using Feedback = LimitedFeedback;
};

}  // namespace

void add_haptic(std::vector<CompositionRow>& table) {
  add_all<Haptic>(table, "haptic", DeviceKind::impedance);
}

}  // namespace godobject
