// Simulated server of OpenIGTLink: it sends each pose as a TRANSFORM, and after the request for it all poses
// as TDATA.
#pragma once

#include <string>
#include <vector>

#include "hal/tracker/openigtlink.h"
#include "sim/tracker/tracker.h"

namespace godobject {

class SimOpenIgtLink final : public SimTracker {
 public:
  SimOpenIgtLink(const TrackerParams& params, double rate_hz, std::uint64_t seed);

  void receive(std::span<const std::uint8_t> bytes, Nanoseconds now) noexcept override;

 private:
  void measured(Nanoseconds now) noexcept override;

  std::vector<std::string> tools_;
  openigtlink::Receiver receiver_;
  bool sends_tdata_ = false;
};

}  // namespace godobject
