// A scene as written by a new user: a tool on three sliders with encoders and drives, otherwise defaults.
#pragma once

#include <array>
#include <string>

namespace godobject::test {

/// Returns the scene. feedback, plant: lines of [body.feedback] and [device.plant].
inline std::string desk_scene(const std::string& feedback, const std::string& plant = "") {
  std::string text =
      "[scene]\nname = \"mine\"\nduration = 6.0\n"
      "[[body]]\nname = \"tool\"\nmass = 0.1\ninertia = [1e-4, 1e-4, 1e-4]\n"
      "[body.coupling]\nstiffness = 500\nrotational_stiffness = 0.5\n"
      "[body.feedback]\n" +
      feedback + "[device]\nname = \"desk\"\n[device.plant]\n" + plant;
  const std::array<std::string, 3> names{"x", "y", "z"}, axes{"[1, 0, 0]", "[0, 1, 0]", "[0, 0, 1]"},
      hertz{"0.5", "0.7", "0.3"};
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string node =
        "joint = \"" + names[i] + "\"\nnode_id = " + std::to_string(i + 1) + "\ncounts_per_unit = 1e6\n";
    text += "[[device.joint]]\nname = \"" + names[i] + "\"\nkind = \"slider\"\naxis = " + axes[i] + "\n";
    text += "[[device.encoder]]\nbus = \"can0\"\n" + node;
    text +=
        "[[device.drive]]\nbus = \"can1\"\n" + node +
        "torque_max_Nm = 0.2\ntorque_rate_Nm_per_s = 100\njoint_per_motor_rad = 0.02\nwatchdog = \"none\"\n";
  }
  text += "[[bus]]\nname = \"can0\"\n[[bus]]\nname = \"can1\"\n[motion]\n";
  for (std::size_t i = 0; i < names.size(); ++i)
    text += "[[motion.joint]]\ncoordinate = \"" + names[i] +
            "\"\namplitude = 0.03\nfrequency_hz = " + hertz[i] + "\nphase = 1.5707963267948966\n";
  return text;
}

/// A carriage of 1 g with a damper too strong for such a device: former defaults.
inline const std::string light_plant =
    "inertia = 1e-3\ndamping = 1e-2\nfriction = 1e-3\nhand_stiffness = 20\nhand_damping = 0.5\n";
inline const std::string heavy_feedback = "stiffness = 125\ndamping = 2.5\n";

}  // namespace godobject::test
