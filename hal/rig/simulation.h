// Parameters of a simulated device besides the rig that it replaces: mechanics, wires, faults. Plain values,
// SI. Scene files contain them, even if the reading program does not simulate.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/math/types.h"

namespace godobject {

/// Mechanics of a joint of the device and of the hand that moves it. The defaults are for a hinge.
struct JointPlant {
  double inertia = 1e-3;       // inertia at the joint, kg m^2 or kg
  double damping = 1e-2;       // viscous, without the hand, N m s/rad or N s/m
  double friction = 1e-3;      // Coulomb, N m or N
  double hand_stiffness = 20;  // stiffness of the user's arm, N m/rad or N/m
  double hand_damping = 0.5;   // damping of the user's arm, N m s/rad or N s/m
};

/// Mechanics of the simulated rig behind the bus: default of every joint without its own entry.
struct PlantConfig : JointPlant {
  Vec3 gravity_W = Vec3::Zero();  // on the links of the device, m/s^2
  // The hand brings the device to its home pose before the motion begins, and presses its home button.
  bool hand_homes = true;
  struct OfJoint {
    std::string joint;  // name of a joint of the device
    JointPlant plant;
  };
  std::vector<OfJoint> joints{};

  const JointPlant& of(const std::string& joint) const noexcept {
    for (const OfJoint& own : joints)
      if (own.joint == joint) return own.plant;
    return *this;
  }
};

/// Random faults of the simulated wire; all zero by default.
struct WireConfig {
  std::uint64_t seed = 1;
  double loss_probability = 0;        // per frame
  double corruption_probability = 0;  // per frame
  double delay_s = 0;                 // added to every frame
};

/// A fault that the simulated rig injects: verb, place and time.
struct FaultConfig {
  std::string verb;                       // "drop", "unplug", ...: see docs/faults.md
  std::string bus{};                      // name of a bus; empty: all buses, or the bus of the node
  std::optional<std::uint8_t> node_id{};  // node on that bus; none: the bus itself
  std::string tracker{};                  // name of a tracker, instead of a bus
  double at = 0;                          // time of the motion, s
  std::optional<double> duration{};       // s; none: until the end, or one event if the verb is an event
  double value = 0;                       // argument of the verb: probability, s, counts, ppm, code
};

}  // namespace godobject
