// Passivity as texts: table and warnings.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "platform/session/passivity.h"

namespace godobject {
namespace {

template <class... Args>
std::string formatted(const char* format, Args... args) {
  std::array<char, 320> text{};
  std::snprintf(text.data(), text.size(), format, args...);
  return text.data();
}

const char* damping_unit(const JointMargin& joint) { return joint.hinge ? "N m s/rad" : "N s/m"; }

/// Returns the gain to lower, and the percentage that remains.
std::string remedy(SampledAxis axis) {
  std::string without;
  if (const double of_inertia = axis.needed_for_inertia(); of_inertia > 0) {
    const double left = axis.damping - (axis.needed() - of_inertia);
    if (left > 0)
      return formatted("lower inertia in [device.compensation] to %.3g %% of its present value",
                       std::floor(1000 * left / of_inertia) / 10);
    without = "set inertia in [device.compensation] to 0";
    axis.carried = 0;
    if (axis.passive()) return without;
    without += ", ";
  }
  const double of_spring = axis.needed() - std::abs(axis.B);
  const double left = axis.damping - of_spring;
  if (left > 0 || of_spring == 0)
    return without + formatted("lower the feedback's damping to %.3g %% of its present value",
                               std::floor(1000 * std::max(left, 0.0) / std::abs(axis.B)) / 10);
  return without +
         formatted("set the feedback's damping to 0 and lower its stiffness to %.3g %% of its present value",
                   std::floor(1000 * axis.damping / of_spring) / 10);
}

}  // namespace

std::vector<std::string> passivity_table(const Passivity& passivity) {
  if (passivity.joints.empty()) return {};
  std::vector<std::string> lines{
      formatted("# passivity of the driven axes at %s: b > K (T/2 + t_d) + |B|, see docs/theory/passivity.md",
                passivity.ranges.vary() ? "their worst poses" : "the start"),
      formatted("#   %-16s %10s %10s %8s %10s %10s %10s  %s", "joint", "K", "B", "t_d ms", "needed", "b",
                "margin", "verdict")};
  for (const JointMargin& joint : passivity.joints) {
    const SampledAxis& axis = joint.axis;
    const char* const verdict = axis.passive()       ? "passive"
                                : joint.stable_alone ? "stable, not passive"
                                : joint.stable_held  ? "stable only in a hand"
                                                     : "unstable";
    lines.push_back(formatted("#   %-16s %10.3g %10.3g %8.3g %10.3g %10.3g %+10.3g  %s", joint.joint.c_str(),
                              axis.K, axis.B, 1e3 * axis.period_s * axis.delay, axis.needed(), axis.damping,
                              axis.margin(), verdict));
  }
  for (const JointMargin& joint : passivity.joints)
    if (passivity.ranges.vary())
      lines.push_back("#   worst pose of " + joint.joint + ": " + passivity.ranges.text(joint.q));
  if (passivity.joints.size() > 1)
    lines.push_back(formatted("#   all at once: the worst direction needs %.3g times the present damping",
                              passivity.worst_direction));
  lines.push_back(
      "#   K, B: the feedback's gains at the joint, N m/rad and N m s/rad, of a slider N/m and N s/m; t_d: "
      "from "
      "a sample to its torque");
  for (const JointMargin& joint : passivity.joints)
    if (joint.axis.carried > 0)
      lines.push_back(formatted("#   %s: %.3g of the needed damping is for [device.compensation] inertia",
                                joint.joint.c_str(), joint.axis.needed_for_inertia()));
  lines.push_back(
      "#   b: damping of the device without a hand, from [device.plant]; of a real device, measure it and "
      "enter it there");
  return lines;
}

std::vector<std::string> passivity_warnings(const Passivity& passivity) {
  std::vector<std::string> lines;
  for (const JointMargin& joint : passivity.joints) {
    const SampledAxis& axis = joint.axis;
    if (axis.passive()) continue;
    const std::string at = passivity.ranges.vary() ? " at " + passivity.ranges.text(joint.q) : "";
    std::string line = "axis " + joint.joint + " is not passive" + at +
                       formatted(": it needs %.3g %s of its own damping and has %.3g: ", axis.needed(),
                                 damping_unit(joint), axis.damping) +
                       remedy(axis) + ", shorten the step, or build it with more damping";
    if (!joint.stable_alone)
      line += formatted("; %s it is unstable and chatters (feedback damping alone: from %.3g %s on)",
                        joint.stable_held ? "released" : "even in a hand",
                        largest_stable_damping(axis.inertia, axis.period_s, axis.delay), damping_unit(joint));
    lines.push_back(std::move(line));
  }
  if (lines.empty() && !passivity.passive())
    lines.push_back(
        formatted("the axes are passive one by one, but not together: the worst direction needs "
                  "%.3g times the present damping: divide the feedback's gains by that",
                  passivity.worst_direction) +
        (passivity.ranges.vary() ? " (at " + passivity.ranges.text(passivity.worst_q) + ")" : ""));
  return lines;
}

}  // namespace godobject
