// Parameters of a tracker, as in the scene: a slow, delayed source of poses on a serial line or a network.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/math/types.h"

namespace godobject {

/// Protocol of a tracker.
enum class TrackerProtocol : std::uint8_t {
  ndi,          // NDI Combined API: Polaris, Vega, Aurora
  polhemus,     // Fastrak and Liberty, binary records
  openigtlink,  // a server on the network: PLUS, 3D Slicer and others
};

/// Names of TrackerProtocol in scene files, in the order of the enumeration.
inline constexpr std::array tracker_protocol_names{"ndi", "polhemus", "openigtlink"};

/// One tool tracked by a tracker: the target of a body.
struct TrackedToolParams {
  std::string body;  // name of a coupled body; each has at most one source of poses
  std::string tool;  // NDI: port handle ("0A") or definition file of a passive tool; Polhemus: station;
                     // OpenIGTLink: name of its device
  Pose X_TH{};       // target in the tool's frame
};

/// One tracker. It reports poses of tools in its own frame.
struct TrackerParams {
  std::string name;
  TrackerProtocol protocol = TrackerProtocol::ndi;
  std::string port;                 // "/dev/serial/by-id/..."; OpenIGTLink and NDI Vega: "tcp:HOST:PORT"
  std::uint32_t baud = 115200;      // bit/s of the line
  Pose X_WT{};                      // tracker frame in the world
  Vec3 hemisphere = Vec3::UnitX();  // Polhemus: direction from the source to its sensors, in its frame
  double stale_after_s = 0.1;       // age above which a pose is not valid
  double boot_timeout_s = 10;       // from opening the line to the first reply while tracking
  double min_cutoff_hz = 0;         // One-Euro filter; 0: none
  double cutoff_slope_s_per_m = 0;  // One-Euro filter: increase of the cut-off with speed, Hz per m/s
  std::vector<TrackedToolParams> tools;
};

}  // namespace godobject
