// Compositions: tools that follow a pose, nothing back.
#include "platform/engine/of.h"

namespace godobject {
namespace {

template <class I, std::size_t N>
struct Followers {
  static constexpr std::size_t max_bodies = N;
  using Integrator = I;
  using Device = PoseDevice;
  using Coupling = DampedSpring;
  using Joints = None;
  using Feedback = None;
};

}  // namespace

void add_pose(std::vector<CompositionRow>& table) {
  add_all<Followers>(table, "pose", DeviceKind::non_haptic);
}

}  // namespace godobject
