#include "sim/tracker/openigtlink.h"

#include <algorithm>

namespace godobject {

SimOpenIgtLink::SimOpenIgtLink(const TrackerParams& params, double rate_hz, std::uint64_t seed)
    : SimTracker(rate_hz, seed) {
  for (const TrackedToolParams& tool : params.tools) tools_.push_back(tool.tool);
  tools_.resize(std::min(tools_.size(), max_tracked_tools));
}

void SimOpenIgtLink::receive(std::span<const std::uint8_t> bytes, Nanoseconds /*now*/) noexcept {
  while (!bytes.empty())
    if (receiver_.push(bytes) == openigtlink::Receiver::Event::passed)
      sends_tdata_ = std::string_view(receiver_.header().type.data()) == "STT_TDATA";
}

void SimOpenIgtLink::measured(Nanoseconds now) noexcept {
  constexpr std::uint64_t six_degrees_of_freedom = 2;
  openigtlink::Message all("TDATA", "tracker", measurement().t);
  bool has_any = false;
  for (std::size_t i = 0; i < tools_.size(); ++i) {
    if (faults.missing[i] || faults.disabled[i]) continue;
    const Pose& X_TH = measurement().poses[i];
    has_any = true;
    all.text(tools_[i], openigtlink::max_name).number(six_degrees_of_freedom, 1).number(0, 1).pose(X_TH);
    if (sends_tdata_) continue;
    openigtlink::Message one("TRANSFORM", tools_[i], measurement().t);
    send(one.pose(X_TH).finish(), now);
  }
  if (has_any && sends_tdata_) send(all.finish(), now);
}

}  // namespace godobject
