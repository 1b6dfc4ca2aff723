// Compositions: a device that takes hold of bodies, one at a time, and shows the force on the held one.
#include "platform/engine/of.h"

namespace godobject {
namespace {

template <class I, std::size_t N>
struct Holding {
  static constexpr std::size_t max_bodies = N;
  using Integrator = I;
  using Device = HoldingDevice;
  using Coupling = DampedSpring;
  using Joints = None;
  using Feedback = LimitedFeedback;
};

}  // namespace

void add_holding(std::vector<CompositionRow>& table) {
  add_all<Holding>(table, "holding", DeviceKind::impedance);
}

}  // namespace godobject
