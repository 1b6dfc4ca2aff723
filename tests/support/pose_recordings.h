// Recorded hand motions as paths in time, and their samples by a slow, delayed tracker.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "core/body/target.h"
#include "tests/support/ndi_stream.h"
#include "tests/support/polhemus_recording.h"
#include "tests/support/shared_data.h"

namespace godobject::test {

/// Poses at a constant rate.
struct Recording {
  std::string name;
  double rate_hz = 0;
  std::vector<Pose> poses;

  double duration() const { return static_cast<double>(poses.size() - 4) / rate_hz; }
  /// Returns the assumed path of the hand: Catmull-Rom through the positions. t: s, in [0, duration()].
  Target at(double t) const {
    const double x = std::clamp(t, 0.0, duration()) * rate_hz + 1;
    const auto i = static_cast<std::size_t>(x);
    const Target a{.X_WD = poses[i], .V_WD = {.w = Vec3::Zero(), .v = speed(i)}};
    const Target b{.X_WD = poses[i + 1], .V_WD = {.w = Vec3::Zero(), .v = speed(i + 1)}};
    return interpolated<Real>(a, b, x - static_cast<double>(i), 1 / rate_hz);
  }

 private:
  Vec3 speed(std::size_t i) const { return 0.5 * rate_hz * (poses[i + 1].p - poses[i - 1].p); }
};

/// Stylus of the PLUS recording, 15 Hz.
inline Recording read_plus_stylus() {
  Recording recording{.name = "PLUS stylus", .rate_hz = 15, .poses = {}};
  std::ifstream in(shared_file("data/plus_tracker/EightLandmarkPointsTrackedForPhantomRegistration.igs.mha"));
  for (std::string line; std::getline(in, line);) {
    const std::size_t value = line.find("StylusToTrackerTransform = ");
    if (value == std::string::npos) continue;
    std::istringstream numbers(line.substr(line.find('=') + 1));
    std::array<double, 16> m{};
    for (double& x : m) numbers >> x;
    recording.poses.push_back({.p = 1e-3 * Vec3(m[3], m[7], m[11]), .q = Quat::Identity()});
  }
  return recording;
}

/// Longest run of consecutive frames of the Polaris recording, 60 Hz.
inline Recording read_polaris() {
  Recording best{.name = "NDI Polaris", .rate_hz = 60, .poses = {}}, run = best;
  const auto path = shared_file("data/ndi/streams/polaris_stream_03_31_2005_1.txt");
  if (path.empty()) return best;
  unsigned long last = 0;
  for (const NdiExchange& exchange : read_tagged_stream(path)) {
    const std::string text(exchange.reply.begin(), exchange.reply.end());
    const bool pose = exchange.command.starts_with("TX:") && text.size() > 70 && text[4] != 'M';
    const unsigned long frame = pose ? std::stoul(text.substr(63, 8), nullptr, 16) : 0;
    if (!pose || frame != last + 1) run.poses.clear();
    last = frame;
    if (!pose) continue;
    const auto coordinate = [&](std::size_t at) { return 1e-5 * std::stoi(text.substr(at, 7)); };
    run.poses.push_back({.p = Vec3(coordinate(28), coordinate(35), coordinate(42)), .q = Quat::Identity()});
    if (run.poses.size() > best.poses.size()) best = run;
  }
  return best;
}

/// One Fastrak recording, 100 Hz.
inline Recording read_fastrak() {
  return {.name = "Fastrak hand",
          .rate_hz = 100,
          .poses = read_matrices(shared_file("data/polhemus_fastrak_hand/user3_cup1.traj"))};
}

/// Distinct poses of the DESK recording as sent by the robot, about 120 Hz.
inline Recording read_desk() {
  Recording recording{.name = "DESK", .rate_hz = 120, .poses = {}};
  std::ifstream in(shared_file("data/desk_taurus/S5_T2_left_kinematics.txt"));
  for (std::string line; std::getline(in, line);) {
    std::istringstream numbers(line);
    std::array<double, 13> v{};
    for (double& x : v) numbers >> x;
    const Vec3 p = 1e-6 * Vec3(v[10], v[11], v[12]);
    if (recording.poses.empty() || recording.poses.back().p != p)
      recording.poses.push_back({.p = p, .q = Quat::Identity()});
  }
  return recording;
}

}  // namespace godobject::test
