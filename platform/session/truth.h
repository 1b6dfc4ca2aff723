// What only a simulated run knows: where the handle really is, and what a perfect device would have made of it.
#pragma once

#include <span>
#include <vector>

#include "platform/engine/engine.h"

namespace godobject {

/// An observer beside the session: nothing it does changes what the bodies do.
class Truth {
 public:
  virtual ~Truth() = default;

  /// The session starts with these samples. Allocates.
  virtual void start(std::span<const BodySample> samples) = 0;
  /// The session's engine is about to have made the step to t (s, of the motion) with these samples. Real-time.
  virtual void step(double t, std::span<const BodySample> samples) noexcept = 0;
  /// Where the handle of this driven body really is.
  virtual const Pose& handle(std::size_t body) const noexcept = 0;
  /// The body as a perfect device would have moved it. Real-time.
  virtual BodyView exact(std::size_t body) const noexcept = 0;
  /// False when the motion left the workspace of the simulated device.
  virtual bool reachable() const noexcept = 0;
  /// Mean load of each bus so far, percent.
  virtual std::vector<double> bus_load_percent() const = 0;
};

}  // namespace godobject
