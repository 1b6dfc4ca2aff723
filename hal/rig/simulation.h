// What a simulated device is made of besides the rig it stands in for: mechanics, wires, faults. Plain values, SI: scene files
// have them, whether what reads the file simulates or not.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace godobject {

/// Mechanics of a joint of the device, and of the hand that moves it. The defaults are of a turn.
struct JointPlant {
  double inertia = 1e-3;       // at the joint, kg m^2 or kg
  double damping = 1e-2;       // viscous, without the hand, N m s/rad or N s/m
  double friction = 1e-3;      // Coulomb, N m or N
  double hand_stiffness = 20;  // of the user's arm, N m/rad or N/m
  double hand_damping = 0.5;   // of the user's arm, N m s/rad or N s/m
};

/// Mechanics of the simulated rig behind the bus: those of every joint that has none of its own.
struct PlantConfig : JointPlant {
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

/// Faults the simulated wire makes by chance; all zero by default.
struct WireConfig {
  std::uint64_t seed = 1;
  double loss_probability = 0;        // per frame
  double corruption_probability = 0;  // per frame
  double delay_s = 0;                 // added to every frame
};

/// A fault that the simulated rig plays: what it is, where, and when.
struct FaultConfig {
  std::string verb;                       // "drop", "unplug", ...: see docs/faults.md
  std::string bus{};                      // name of a bus; empty: all, or the bus of the node
  std::optional<std::uint8_t> node_id{};  // of a node on that bus; none: the bus itself
  std::string tracker{};                  // name of a tracker instead
  double at = 0;                          // s of the motion
  std::optional<double> duration{};       // s; none: to the end, or one event where the verb is one
  double value = 0;                       // the verb's own: probability, s, counts, ppm, code
};

}  // namespace godobject
