#include "platform/cli/time_to_zero.h"

#include <array>
#include <cstdio>

#include "hal/rig/watchdog.h"

namespace godobject {
namespace {

std::string row(const std::string& drive, const std::string& time, const std::string& mechanism) {
  std::array<char, 48> columns{};
  std::snprintf(columns.data(), columns.size(), "#   %-24.24s %8s   ", drive.c_str(), time.c_str());
  return columns.data() + mechanism;
}

std::string milliseconds(const std::optional<double>& s) {
  if (!s) return "never";
  std::array<char, 24> text{};
  std::snprintf(text.data(), text.size(), "%.3g ms", 1e3 * *s);
  return text.data();
}

}  // namespace

std::vector<std::string> time_to_zero_lines(const RigParams& rig, double cycle_s,
                                            const RigProfiles& profiles) {
  if (rig.drives.empty()) return {};
  std::vector<std::string> lines{"# time to zero torque after the death of this program"};
  for (std::size_t i = 0; i < rig.drives.size(); ++i) {
    const DriveParams& drive = rig.drives[i];
    const TimeToZero time = time_to_zero(rig, cycle_s, i, profiles);
    lines.push_back(
        row(drive.joint + " (" + rig.buses[drive.bus].name + " node " + std::to_string(drive.node_id) + ")",
            milliseconds(time.s), time.mechanism));
  }
  return lines;
}

}  // namespace godobject
