// Compositions: tools moved by a force.
#include "sim/engine_of.h"

namespace godobject {
namespace {

template <class I, std::size_t N>
struct Admittance {
  static constexpr std::size_t max_bodies = N;
  using Integrator = I;
  using Device = AdmittanceDevice;
  using Coupling = DampedSpring;
  using Joints = None;
  using Feedback = None;
};

}  // namespace

void add_admittance(std::vector<CompositionRow>& table) {
  add_all<Admittance>(table, "admittance", DeviceKind::admittance);
}

}  // namespace godobject
