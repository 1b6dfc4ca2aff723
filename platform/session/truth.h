// Interface to the exact state of a simulated device: true pose of the handle, and errors against an ideal
// device.
#pragma once

#include <span>
#include <vector>

#include "platform/session/record.h"

namespace godobject {

/// Bodies that follow the device in a period.
struct Followed {
  std::span<const std::size_t> bodies;
  std::span<const BodySample> samples;  // one for each body of the scene, as passed to the core
  bool by_an_offset = false;  // true if handle and target differ by an offset; the error of a body is then
                              // against its target
};

/// Observer beside the session: does not influence the bodies.
class Truth {
 public:
  virtual ~Truth() = default;

  /// Starts with the scene and the samples of the session. Allocates.
  virtual void start(const SceneConfig& scene, std::span<const BodySample> samples) = 0;
  /// Advances to t before the session's record is written. Real-time.
  /// t: time of the motion, s. samples: as in the engine's step to t.
  virtual void step(double t, std::span<const BodySample> samples) noexcept = 0;
  /// Writes the errors of the record that are measured against the true handle. Real-time.
  virtual void measure(const Followed& followed, CycleRecord& record) const noexcept = 0;
  /// False if the motion left the workspace of the simulated device.
  virtual bool reachable() const noexcept = 0;
  /// Mean load of each bus so far, percent.
  virtual std::vector<double> bus_load_percent() const = 0;
};

}  // namespace godobject
