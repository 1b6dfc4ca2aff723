// Compositions: articulated tools that follow poses and show forces; bare, and with stops and imposed joints.
#include "sim/engine_of.h"

namespace godobject {
namespace {

template <class I, std::size_t N>
struct HapticTool {
  static constexpr std::size_t max_bodies = N;
  using Integrator = I;
  using Device = PoseDevice;
  using Joints = TreeJoints<>;
  using Coupling = DampedSpring;
  using Feedback = LimitedFeedback;
};

template <class I, std::size_t N>
struct HapticToolWithAll {
  static constexpr std::size_t max_bodies = N;
  using Integrator = I;
  using Device = PoseDevice;
  using Joints = TreeJoints<JointStops, ImposedJoints>;
  using Coupling = DampedSpring;
  using Feedback = LimitedFeedback;
};

}  // namespace

void add_haptic_joints(std::vector<CompositionRow>& table) {
  add_both<HapticTool, 8>(table, "haptic-joints", DeviceKind::impedance);
  add_both<HapticToolWithAll, 8>(table, "haptic-joints-stops-imposed", DeviceKind::impedance);
}

}  // namespace godobject
