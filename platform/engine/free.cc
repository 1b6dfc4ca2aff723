// Compositions: free bodies, no device.
#include "platform/engine/of.h"

namespace godobject {
namespace {

template <class I, std::size_t N>
struct FreeBodies {
  static constexpr std::size_t max_bodies = N;
  using Integrator = I;
  using Device = None;
  using Coupling = None;
  using Joints = None;
  using Feedback = None;
};

}  // namespace

void add_free(std::vector<CompositionRow>& table) {
  add_all<FreeBodies>(table, "free", DeviceKind::non_haptic);
}

}  // namespace godobject
