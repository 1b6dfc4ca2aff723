// Compositions: articulated bodies without a device, with and without stops; and long chains.
#include "sim/engine_of.h"

namespace godobject {
namespace {

template <class I, std::size_t N>
struct FreeTool {
  static constexpr std::size_t max_bodies = N;
  using Integrator = I;
  using Device = None;
  using Joints = TreeJoints<>;
  using Coupling = None;
  using Feedback = None;
};

template <class I, std::size_t N>
struct FreeToolWithStops {
  static constexpr std::size_t max_bodies = N;
  using Integrator = I;
  using Device = None;
  using Joints = TreeJoints<JointStops>;
  using Coupling = None;
  using Feedback = None;
};

}  // namespace

void add_free_joints(std::vector<CompositionRow>& table) {
  add_both<FreeTool, 8>(table, "free-joints", DeviceKind::non_haptic);
  add_both<FreeToolWithStops, 8>(table, "free-joints-stops", DeviceKind::non_haptic);
  add_both<FreeTool, 256>(table, "free-joints", DeviceKind::non_haptic);
}

}  // namespace godobject
