// A tracker as the scene describes it: a slow, late source of poses on a serial line.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/math/types.h"

namespace godobject {

/// What a tracker speaks.
enum class TrackerProtocol : std::uint8_t {
  ndi,       // NDI Combined API: Polaris, Vega, Aurora
  polhemus,  // Fastrak and Liberty, binary records
};

/// Names of TrackerProtocol in scene files, in its order.
inline constexpr std::array tracker_protocol_names{"ndi", "polhemus"};

/// One tool that a tracker sees: the target of a body.
struct TrackedToolParams {
  std::string body;  // name of a coupled body; each has at most one source of poses
  std::string tool;  // NDI: port handle ("0A") or the file of a passive tool's definition; Polhemus: station
  Pose X_TH{};       // the target in the tool's frame
};

/// One tracker. Poses it reports are those of the tool in its own frame.
struct TrackerParams {
  std::string name;
  TrackerProtocol protocol = TrackerProtocol::ndi;
  std::string port;                 // "/dev/serial/by-id/..."
  std::uint32_t baud = 115200;      // bit/s on the line
  Pose X_WT{};                      // the tracker's frame in the world
  Vec3 hemisphere = Vec3::UnitX();  // Polhemus: from the source to where its sensors are, in its frame
  double stale_after_s = 0.1;       // a pose older than this is not valid any more
  double boot_timeout_s = 10;       // from opening the line to the first reply while tracking
  double min_cutoff_hz = 0;         // One-Euro filter; 0: none
  double cutoff_slope_s_per_m = 0;  // One-Euro filter: cut-off added per speed, Hz per m/s
  std::vector<TrackedToolParams> tools;
};

}  // namespace godobject
