// Compositions: tools moved by a force, with and without a spring.
#include "platform/engine/of.h"

namespace godobject {
namespace {

template <class I, std::size_t N>
struct Admittance {
  static constexpr std::size_t max_bodies = N;
  using Integrator = I;
  using Device = AdmittanceDevice;
  using Coupling = None;
  using Joints = None;
  using Feedback = None;
};

template <class I, std::size_t N>
struct AdmittanceOnSpring {
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
  add_all<AdmittanceOnSpring>(table, "admittance-spring", DeviceKind::admittance);
}

}  // namespace godobject
