#include "hal/tracker/tracker.h"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>

#include "hal/tracker/ndi_tracker.h"
#include "hal/tracker/openigtlink_tracker.h"
#include "hal/tracker/polhemus_tracker.h"

namespace godobject {

const char* name(ToolState state) noexcept {
  static constexpr std::array names{"unseen", "valid", "missing", "disabled", "out of volume", "stale"};
  return names[static_cast<std::size_t>(state)];
}

const char* name(TrackerState state) noexcept {
  static constexpr std::array names{"opening", "initialising", "tracking", "failed"};
  return names[static_cast<std::size_t>(state)];
}

Tracker::Tracker(const TrackerParams& params)
    : params_(params), stale_after_ns_(std::llround(params.stale_after_s * 1e9)) {}

void Tracker::enter(TrackerState state, const char* format, ...) noexcept {
  report_.state = state;
  std::va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(report_.text.data(), report_.text.size(), format, arguments);
  va_end(arguments);
}

void Tracker::line_lost(const std::string& why, bool too_long, Nanoseconds now) noexcept {
  enter(too_long ? TrackerState::failed : TrackerState::opening, "%s", why.c_str());
  expire(now + stale_after_ns_ + 1);
}

void Tracker::expire(Nanoseconds now) noexcept {
  for (ToolSample& sample : report_.tools) {
    if (sample.state != ToolState::unseen && now - sample.t_ns > stale_after_ns_)
      sample.state = ToolState::stale;
  }
}

void Tracker::measured(std::size_t tool, const Pose& X_TH, std::uint32_t frame, double error_m,
                       ToolState state, Nanoseconds t) noexcept {
  ToolSample& sample = report_.tools[tool];
  if (sample.number > 0 && frame == sample.frame) {
    ++report_.counters.repeated;
    return;
  }
  const std::uint32_t skipped = frame - sample.frame - 1;
  // a counter that decreased or jumped was restarted
  if (sample.number > 0 && skipped < 1000) report_.counters.lost_frames += skipped;
  ++report_.counters.samples;
  sample = {.state = state,
            .X_TH = X_TH,
            .frame = frame,
            .number = sample.number + 1,
            .t_ns = t,
            .error_m = error_m};
}

void Tracker::not_measured(std::size_t tool, ToolState state, Nanoseconds t) noexcept {
  report_.tools[tool].state = state;
  report_.tools[tool].t_ns = t;
}

bool needs_definition(TrackerProtocol protocol, const std::string& tool) {
  return protocol == TrackerProtocol::ndi && !ndi_handle(tool);
}

MadeTracker make_tracker(const TrackerParams& params, ToolDefinitions definitions) {
  MadeTracker made;
  if (params.tools.empty() || params.tools.size() > max_tracked_tools)
    made.errors.push_back("tracker '" + params.name + "' must have 1 to " +
                          std::to_string(max_tracked_tools) + " tools, not " +
                          std::to_string(params.tools.size()));
  definitions.resize(params.tools.size());
  if (!made.errors.empty()) return made;
  switch (params.protocol) {
    case TrackerProtocol::ndi:
      made.tracker = make_ndi_tracker(params, std::move(definitions), made.errors);
      break;
    case TrackerProtocol::polhemus: made.tracker = make_polhemus_tracker(params, made.errors); break;
    case TrackerProtocol::openigtlink: made.tracker = make_openigtlink_tracker(params, made.errors); break;
  }
  return made;
}

}  // namespace godobject
