// Compositions: tools moved by increments through a clutch, with and without a shown force.
#include "platform/engine/of.h"

namespace godobject {
namespace {

template <class I, std::size_t N>
struct Relative {
  static constexpr std::size_t max_bodies = N;
  using Integrator = I;
  using Device = RelativeDevice;
  using Coupling = DampedSpring;
  using Joints = None;
  using Feedback = None;
};

template <class I, std::size_t N>
struct RelativeHaptic {
  static constexpr std::size_t max_bodies = N;
  using Integrator = I;
  using Device = RelativeDevice;
  using Coupling = DampedSpring;
  using Joints = None;
  using Feedback = LimitedFeedback;
};

}  // namespace

void add_relative(std::vector<CompositionRow>& table) {
  add_all<Relative>(table, "relative", DeviceKind::relative);
  add_all<RelativeHaptic>(table, "relative-haptic", DeviceKind::relative);
}

}  // namespace godobject
