// What only a simulated run knows: where the handle really is, and what a perfect device would have made of it.
#pragma once

#include <span>
#include <vector>

#include "platform/session/record.h"

namespace godobject {

/// What follows the device in a period.
struct Followed {
  std::span<const std::size_t> bodies;
  std::span<const BodySample> samples;  // one for each body of the scene, as the core got them
  bool by_an_offset = false;  // between handle and target: a body's error is that against its target
};

/// An observer beside the session: nothing it does changes what the bodies do.
class Truth {
 public:
  virtual ~Truth() = default;

  /// The session starts with these samples. Allocates.
  virtual void start(std::span<const BodySample> samples) = 0;
  /// The session's engine is about to have made the step to t (s, of the motion) with these samples. Real-time.
  virtual void step(double t, std::span<const BodySample> samples) noexcept = 0;
  /// What of the record's errors is against the handle as it really is. Real-time.
  virtual void measure(const Followed& followed, CycleRecord& record) const noexcept = 0;
  /// False when the motion left the workspace of the simulated device.
  virtual bool reachable() const noexcept = 0;
  /// Mean load of each bus so far, percent.
  virtual std::vector<double> bus_load_percent() const = 0;
};

}  // namespace godobject
