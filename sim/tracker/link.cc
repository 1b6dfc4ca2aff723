#include "sim/tracker/link.h"

namespace godobject {

bool SimTrackerLink::try_read(TrackerReport& out, Nanoseconds now) noexcept {
  if (!opened_) tracker_->opened(now);
  opened_ = true;
  far_->advance(now);
  std::array<std::uint8_t, 256> bytes{};
  while (const std::size_t size = far_->transmit(bytes, now)) tracker_->receive({bytes.data(), size}, now);
  for (LineRequest request = tracker_->next(now); request.kind != LineRequest::Kind::none;
       request = tracker_->next(now)) {
    if (request.kind == LineRequest::Kind::send) far_->receive(request.bytes, now);
    if (request.kind == LineRequest::Kind::serial_break) far_->serial_break(now);
    if (request.kind == LineRequest::Kind::reopen) tracker_->opened(now);
  }
  out = tracker_->report();
  return true;
}

std::unique_ptr<SimTrackerLink> make_sim_tracker_link(const TrackerParams& params, double rate_hz,
                                                      std::uint64_t seed, std::vector<std::string>& errors) {
  ToolDefinitions definitions(params.tools.size());
  for (std::size_t i = 0; i < params.tools.size(); ++i) {
    if (needs_definition(params.protocol, params.tools[i].tool)) definitions[i].assign(752, 0);
  }
  MadeTracker made = make_tracker(params, std::move(definitions));
  errors.insert(errors.end(), made.errors.begin(), made.errors.end());
  if (!made.tracker) return nullptr;
  return std::make_unique<SimTrackerLink>(std::move(made.tracker), make_sim_tracker(params, rate_hz, seed));
}

/// X_TH = X_WT^-1 X_WD X_HT, with X_HT the inverse of the target's pose on the tool.
Pose tool_pose_for(const TrackerParams& params, std::size_t tool, const Pose& X_WD) noexcept {
  const Pose& X_TH = params.tools[tool].X_TH;
  const Quat q = X_WD.q * X_TH.q.conjugate();
  const Vec3 p = X_WD.p - q * X_TH.p;
  const Quat to_tracker = params.X_WT.q.conjugate();
  return {.p = to_tracker * (p - params.X_WT.p), .q = to_tracker * q};
}

}  // namespace godobject
