#include "hal/tracker/openigtlink_tracker.h"

#include <algorithm>

namespace godobject {
namespace {

constexpr Nanoseconds message_patience = 5'000'000'000;

}  // namespace

std::unique_ptr<Tracker> make_openigtlink_tracker(const TrackerParams& params,
                                                  std::vector<std::string>& errors) {
  for (const TrackedToolParams& tool : params.tools)
    if (tool.tool.empty() || tool.tool.size() > openigtlink::max_name)
      errors.push_back("tracker '" + params.name + "': tool '" + tool.tool +
                       "' must be the name of a device of OpenIGTLink, 1 to " +
                       std::to_string(openigtlink::max_name) + " characters");
  if (!errors.empty()) return nullptr;
  return std::make_unique<OpenIgtLinkTracker>(params);
}

void OpenIgtLinkTracker::opened(Nanoseconds now) noexcept {
  if (report_.counters.samples > 0) ++report_.counters.restarts;
  receiver_.reset();
  clock_ = {};
  newest_ = {};
  is_requested_ = is_unreadable_ = false;
  boot_deadline_ = now + to_ns(params_.boot_timeout_s);
  enter(TrackerState::initialising, "connected to %.60s: no pose yet", params_.port.c_str());
}

void OpenIgtLinkTracker::receive(std::span<const std::uint8_t> bytes, Nanoseconds now) noexcept {
  using Event = openigtlink::Receiver::Event;
  while (!bytes.empty() && !is_unreadable_) {
    if (!receiver_.is_amid()) message_since_ = now;
    switch (receiver_.push(bytes)) {
      case Event::more: break;
      case Event::message: take_message(now); break;
      case Event::passed:
        if (report_.state != TrackerState::tracking)
          enter(report_.state, "messages come, the last one %.12s of '%.20s', but no pose yet",
                receiver_.header().type.data(), receiver_.header().device.data());
        break;
      case Event::bad_crc: ++report_.counters.bad_crc; break;
      case Event::malformed: ++report_.counters.malformed; break;
      case Event::no_header: lose_track("sends no OpenIGTLink: check host and port"); break;
    }
  }
}

/// Counts a malformed message, after which the byte stream cannot be decoded. why: text after the server's
/// name.
void OpenIgtLinkTracker::lose_track(const char* why) noexcept {
  ++report_.counters.malformed;
  is_unreadable_ = true;
  receiver_.reset();
  enter(TrackerState::failed, "%.60s %s", params_.port.c_str(), why);
}

void OpenIgtLinkTracker::take_message(Nanoseconds now) noexcept {
  const Nanoseconds stamp = receiver_.header().t, t = stamp == 0 ? now : clock_.to_local(stamp, now);
  for (std::size_t i = 0; i < receiver_.num_poses(); ++i) {
    const openigtlink::ToolPose pose = receiver_.pose(i);
    const auto tool = std::ranges::find(params_.tools, pose.name, &TrackedToolParams::tool);
    if (tool == params_.tools.end()) {
      if (report_.state != TrackerState::tracking)
        enter(report_.state, "poses come, the last one of '%.*s', but none of the tools of the scene",
              static_cast<int>(pose.name.size()), pose.name.data());
    } else if (!pose.X_TH) {
      ++report_.counters.malformed;
    } else {
      take_pose(static_cast<std::size_t>(tool - params_.tools.begin()), *pose.X_TH, t, now);
    }
  }
}

/// Accepts a pose unless it is not newer than an earlier one, or stale on its arrival.
/// t: its time on the host's clock.
void OpenIgtLinkTracker::take_pose(std::size_t tool, const Pose& X_TH, Nanoseconds t,
                                   Nanoseconds now) noexcept {
  const Nanoseconds stamp = receiver_.header().t == 0 ? now : receiver_.header().t;
  // A larger step back is a restarted clock, and the pose is accepted.
  if (stamp <= newest_[tool] && newest_[tool] - stamp < StampClock::step_limit) {
    ++report_.counters.repeated;
    return;
  }
  newest_[tool] = stamp;
  if (now - t > stale_after_ns_) {
    ++report_.counters.lost_frames;
    return;
  }
  measured(tool, X_TH, ++count_[tool], 0, ToolState::valid, t);
  if (report_.state != TrackerState::tracking)
    enter(TrackerState::tracking, "%.60s, OpenIGTLink version %u", params_.port.c_str(),
          unsigned{receiver_.header().version});
}

LineRequest OpenIgtLinkTracker::next(Nanoseconds now) noexcept {
  expire(now);
  if (receiver_.is_amid() && now - message_since_ > message_patience)
    lose_track("sends a message without an end: check the server");
  if (is_unreadable_) {
    is_unreadable_ = false;
    return {.kind = LineRequest::Kind::reopen};
  }
  if (!is_requested_) {
    // Requests poses at the server's own rate (interval 0) and in its own coordinate system (empty name).
    is_requested_ = true;
    request_ = openigtlink::Message("STT_TDATA", "", 0);
    return {.kind = LineRequest::Kind::send, .bytes = request_.number(0, 4).text("", 32).finish()};
  }
  if (report_.state == TrackerState::initialising && now >= boot_deadline_) {
    report_.state = TrackerState::failed;  // the report keeps the text of the last failure
    return {.kind = LineRequest::Kind::reopen};
  }
  return {};
}

}  // namespace godobject
