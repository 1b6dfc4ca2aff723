// Faults (data or motion was lost) and limits (a quantity was bounded on purpose) that a step reports.
#pragma once

#include <cstdint>

namespace godobject {

/// Fault bits. docs/faults.md has a paragraph for each.
enum class Fault : std::uint32_t {
  none = 0,
  input_not_finite = 1u << 0,  // NaN or infinity in an input: the step was not taken
  // target quaternion off unit length by more than 1e-6, or increment above half a turn; sample rejected
  input_not_unit = 1u << 1,
  state_not_finite = 1u << 2,  // the step's result was not finite: it was not committed
  contacts_full = 1u << 3,  // more contacts than max_contacts: the deepest were kept, and the step was taken
  // contacts couple more pairs of bodies than there are blocks; solved by iteration, step taken
  blocks_full = 1u << 4,
  // total energy increased without external work (EnergyBalance); or one step raised it beyond (58) and was
  // not taken
  energy_gained = 1u << 5,
};

/// Limit bits: bounds that were active in this step.
enum class Limited : std::uint32_t {
  none = 0,
  force = 1u << 0,             // feedback force at its limit
  torque = 1u << 1,            // feedback torque at its limit
  force_rate = 1u << 2,        // feedback force changes as fast as allowed
  torque_rate = 1u << 3,       // feedback torque changes as fast as allowed
  ramp = 1u << 4,              // coupling and feedback still rising after engaging
  held = 1u << 5,              // no valid sample: the target rests at the last one
  first_order = 1u << 6,       // TR-BDF2 took implicit Euler stages: a body rotated too far, or forces jumped
  contact_residual = 1u << 7,  // a contact force deviates from its law by more than doubtful_residual of the
                               // largest one
  newton_cap = 1u << 8,  // Newton's method over the modes of contacts (29) was cut off before it converged
  substeps = 1u << 9,    // a stage was subdivided, because joints did not hold in one piece (39)
  net_cap = 1u << 10,    // the iteration of nets was cut off at max_iterations, before its tolerance
};

constexpr Fault operator|(Fault a, Fault b) noexcept { return Fault(std::uint32_t(a) | std::uint32_t(b)); }
constexpr Fault& operator|=(Fault& a, Fault b) noexcept { return a = a | b; }
constexpr bool any(Fault a) noexcept { return a != Fault::none; }
constexpr bool has(Fault a, Fault b) noexcept { return (std::uint32_t(a) & std::uint32_t(b)) != 0; }

constexpr Limited operator|(Limited a, Limited b) noexcept {
  return Limited(std::uint32_t(a) | std::uint32_t(b));
}
constexpr Limited& operator|=(Limited& a, Limited b) noexcept { return a = a | b; }
constexpr bool has(Limited a, Limited b) noexcept { return (std::uint32_t(a) & std::uint32_t(b)) != 0; }

}  // namespace godobject
