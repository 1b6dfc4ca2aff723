// Compositions: articulated tools with stops that follow poses and show forces.
#include "sim/engine_of.h"

namespace godobject {
namespace {

template <class I, std::size_t N>
struct HapticToolWithStops {
  static constexpr std::size_t max_bodies = N;
  using Integrator = I;
  using Device = PoseDevice;
  using Joints = TreeJoints<JointStops>;
  using Coupling = DampedSpring;
  using Feedback = LimitedFeedback;
};

}  // namespace

void add_haptic_stops(std::vector<CompositionRow>& table) {
  add_both<HapticToolWithStops, 8>(table, "haptic-joints-stops", DeviceKind::impedance);
}

}  // namespace godobject
