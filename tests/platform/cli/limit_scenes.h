// Scenes that meet the limits of a run.
#pragma once

#include <array>
#include <cmath>
#include <string>

#include "tests/support/desk_scene.h"
#include "tests/support/program.h"

namespace godobject::test::test_limit_remedies {

/// Returns `text` with its first `from` replaced; it must be there.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

inline std::string replaced_everywhere(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

/// A tool on three slides with a feedback that its device bears; limits: lines of [device.limits].
inline std::string desk(const std::string& limits = "") {
  const std::string scene = desk_scene("stiffness = 60\ndamping = 0.6\n");
  return replaced(scene, "[device.plant]\n", "[device.limits]\n" + limits + "[device.plant]\n");
}

/// A tool that a tracked hand turns to and fro; limits: lines of [device.limits].
inline std::string turned(const std::string& limits) {
  return "[scene]\nname = \"turned\"\nduration = 4.0\n"
         "[[body]]\nname = \"tool\"\nmass = 0.1\ninertia = [1e-4, 1e-4, 1e-4]\n"
         "[body.coupling]\nstiffness = 500\nrotational_stiffness = 0.5\n"
         "[body.feedback]\nstiffness = 60\nrotational_stiffness = 0.1\nrotational_damping = 1e-3\n"
         "[device]\nname = \"hand\"\n[device.limits]\n" +
         limits + "[motion]\nangle_amplitude = [0.8, 0.0, 0.0]\nangle_frequency_hz = [1.0, 1.0, 1.0]\n";
}

/// A free body at 400 rad/s: TR-BDF2 takes implicit Euler stages where a step turns it by more than 0.25 rad.
inline std::string spun(const std::string& step) {
  return "[scene]\nname = \"spun\"\nduration = 2.0\nintegrator = \"tr-bdf2\"\nstep = " + step +
         "\n[[body]]\nname = \"tool\"\nmass = 0.1\ninertia = [1e-4, 2e-4, 3e-4]\nangular_velocity = [400.0, "
         "0.0, 0.0]\n";
}

/// The net of a shipped scene with its iterations capped.
inline std::string small_net(const std::string& iterations) {
  const std::string scene = read_file(GODOBJECT_SOURCE_DIR "/sim/scenes/net-small.toml");
  return replaced(scene, "step = 1e-3\n", "step = 1e-3\nnet_iterations = " + iterations + "\n");
}

/// Scene of bricks thrown together over a floor. stiffness: of their contacts, N/m, critically damped for one
/// brick.
inline std::string heap(int bricks, const std::string& step, double stiffness) {
  std::string text =
      "[scene]\nname = \"heap\"\nduration = 1.0\nintegrator = \"implicit-euler\"\nstep = " + step +
      "\ngravity = [0.0, 0.0, -9.81]\n[[obstacle]]\nname = \"floor\"\nkind = \"plane\"\n";
  constexpr double mass = 2.5e-3, golden_angle = 2.39996;
  for (int i = 0; i < bricks; ++i) {
    const double z = 1 - (2 * i + 1) / 8.0, r = std::sqrt(1 - z * z), angle = golden_angle * i;
    const std::array<double, 3> way{r * std::cos(angle), r * std::sin(angle), z};
    const auto vector = [&](double times, double up) {
      return "[" + std::to_string(times * way[0]) + ", " + std::to_string(times * way[1]) + ", " +
             std::to_string(times * way[2] + up) + "]\n";
    };
    text += "[[body]]\nname = \"brick" + std::to_string(i) + "\"\nmass = " + std::to_string(mass) +
            "\ninertia = [7.4e-8, 2.34e-7, 2.67e-7]\nposition = " + vector(0.03, 0.06) +
            "velocity = " + vector(-0.06, 0) + "angular_velocity = " + vector(10, 0) +
            "[[body.shape]]\nkind = \"box\"\nhalf_extents = [0.016, 0.008, 0.005]\n";
    for (const char* y : {"-0.0065", "0.0065"})
      for (const char* z_ : {"-0.0035", "0.0035"})
        text += std::string("[[body.sphere]]\nposition = [-0.0145, ") + y + ", " + z_ +
                "]\nradius = 0.0015\ncount = 2\nspacing = [0.029, 0.0, 0.0]\n";
  }
  return text +
         "[[contact]]\nmaterials = [\"default\", \"default\"]\nstiffness = " + std::to_string(stiffness) +
         "\ndamping = " + std::to_string(2 * std::sqrt(stiffness * mass)) + "\nfriction = 0.5\n";
}

/// Scene of a chain on ball joints, released nearly upright from the world, until it snaps taut. contrast:
/// mass ratio of its last link to the others.
inline std::string chain(const std::string& step, double contrast) {
  constexpr int links = 4;
  constexpr double angle = 175 * 3.14159265358979 / 180, length = 0.1;
  std::string bodies, joints;
  for (int i = 0; i < links; ++i) {
    const double times = i + 1 == links ? contrast : 1, along = (i + 0.5) * length;
    const std::string number = std::to_string(i);
    bodies +=
        "[[body]]\nname = \"link" + number + "\"\nmass = " + std::to_string(0.05 * times) + "\ninertia = [" +
        std::to_string(4.2e-5 * times) + ", " + std::to_string(4.2e-5 * times) + ", " +
        std::to_string(8.3e-7 * times) + "]\nposition = [" + std::to_string(-along * std::sin(angle)) +
        ", 0.0, " + std::to_string(-along * std::cos(angle)) + "]\norientation_wxyz = [" +
        std::to_string(std::cos(angle / 2)) + ", 0.0, " + std::to_string(std::sin(angle / 2)) + ", 0.0]\n";
    joints += "[[joint]]\nname = \"joint" + number + "\"\nkind = \"ball\"\nchild = \"link" + number +
              "\"\nchild_position = [0.0, 0.0, 0.05]\n";
    if (i > 0)
      joints += "parent = \"link" + std::to_string(i - 1) + "\"\nparent_position = [0.0, 0.0, -0.05]\n";
  }
  return "[scene]\nname = \"chain\"\nduration = 0.6\nintegrator = \"implicit-euler\"\nstep = " + step +
         "\ngravity = [0.0, 0.0, -9.81]\n" + bodies + joints;
}

}  // namespace godobject::test::test_limit_remedies
