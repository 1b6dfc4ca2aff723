// NdiTracker: processing of replies.
#include <cstdarg>
#include <cstdio>

#include "hal/tracker/ndi_tracker.h"

namespace godobject {
namespace {

constexpr int max_passes = 4;  // a port with two tools lists the second one after the first is initialised
constexpr std::uint16_t poll_options = ndi::option::transforms | ndi::option::also_out_of_volume;

}  // namespace

void NdiTracker::on_text(std::span<const std::uint8_t> text, Nanoseconds now) noexcept {
  const ndi::TextReply reply = ndi::classify(text);
  awaiting_ = false;
  switch (reply.kind) {
    case ndi::ReplyKind::reset:
      if (step_ == Step::send_break) return go(Step::set_rate);
      return give_up_or_restart("the tracker was reset", now);
    case ndi::ReplyKind::error: return on_error(reply.code, now);
    case ndi::ReplyKind::warning:
      enter(report_.state, "%s: %s", name_of(step_), ndi::warning_text(reply.code));
      return on_okay(now);
    case ndi::ReplyKind::okay: return on_okay(now);
    case ndi::ReplyKind::data: return on_data(text, now);
  }
}

/// Handles an error that does not stop the other tools: a refused tool stays disabled.
void NdiTracker::on_error(std::uint8_t code, Nanoseconds now) noexcept {
  constexpr std::uint8_t invalid_command = 0x01, bad_crc = 0x04;
  if (code == bad_crc && tries_ < max_tries) return;  // the command is repeated
  switch (step_) {
    case Step::free_handle:
    case Step::initialise_handle:
    case Step::enable_handle:
      refuse("%s of port handle %02X: %s", name_of(step_), listed_.handles[at_].handle,
             ndi::error_text(code));
      return next_handle();
    case Step::read_plate: return go(Step::enable_handle);
    case Step::request_handle:
    case Step::write_definition:
      refuse("%s of tool '%.30s': %s", name_of(step_), params_.tools[tool_].tool.c_str(),
             ndi::error_text(code));
      ++tool_;
      return next_definition();
    case Step::start:
      if (plain_start_) break;
      plain_start_ = true;
      return go(Step::start);
    case Step::poll:
      if (poll_ == Poll::tx || code != invalid_command) break;
      poll_ = poll_ == Poll::bx2 ? Poll::bx : Poll::tx;
      return go(Step::poll);
    default: break;
  }
  give_up_or_restart(ndi::error_text(code), now);
}

void NdiTracker::refuse(const char* format, ...) noexcept {
  std::va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(refused_.data(), refused_.size(), format, arguments);
  va_end(arguments);
}

void NdiTracker::on_okay(Nanoseconds now) noexcept {
  switch (step_) {
    case Step::set_rate: return go(Step::follow_rate);
    case Step::initialise: return go(Step::list_used);
    case Step::free_handle:
    case Step::initialise_handle: return next_handle();
    case Step::enable_handle:
      if (const auto tool = tool_of(listed_.handles[at_].handle)) enabled_[*tool] = true;
      return next_handle();
    case Step::write_definition:
      address_ += ndi::block_size;
      if (address_ < definitions_[tool_].size()) return go(Step::write_definition);
      ++tool_;
      return next_definition();
    case Step::start: return go(Step::poll);
    default: ++report_.counters.malformed; return on_lost_reply(now);
  }
}

void NdiTracker::on_data(std::span<const std::uint8_t> text, Nanoseconds now) noexcept {
  switch (step_) {
    case Step::list_used:
    case Step::list_uninitialised:
    case Step::list_disabled: return on_handles(text, now);
    case Step::request_handle: {
      const auto handle = ndi_handle({reinterpret_cast<const char*>(text.data()), text.size()});
      if (!handle) break;
      handles_[tool_] = handle;
      address_ = 0;
      return go(Step::write_definition);
    }
    case Step::read_plate: {
      ndi::ToolPlate plate;
      if (ndi::parse_phinf(text, plate) != ParseResult::ok) break;
      enter(report_.state, "port handle %02X: %s %s", listed_.handles[at_].handle, plate.manufacturer.data(),
            plate.serial.data());
      return go(Step::enable_handle);
    }
    case Step::poll: return on_poses(ndi::ReplyReceiver::Event::text, text, now);
    default: break;
  }
  ++report_.counters.malformed;
  on_lost_reply(now);
}

void NdiTracker::on_handles(std::span<const std::uint8_t> text, Nanoseconds now) noexcept {
  if (ndi::parse_phsr(text, listed_) != ParseResult::ok) {
    ++report_.counters.malformed;
    return on_lost_reply(now);
  }
  at_ = 0;
  if (step_ == Step::list_used) {
    step_ = Step::free_handle;
  } else if (step_ == Step::list_uninitialised) {
    if (++passes_ > max_passes) listed_.size = 0;
    step_ = Step::initialise_handle;
  } else {
    step_ = Step::read_plate;
  }
  --at_;
  next_handle();
}

/// Proceeds to the next listed handle of this step, or to the step after the last one.
void NdiTracker::next_handle() noexcept {
  const bool enabling = step_ == Step::read_plate || step_ == Step::enable_handle;
  do {
    ++at_;
  } while (enabling && at_ < listed_.size && !tool_of(listed_.handles[at_].handle));
  if (at_ < listed_.size) return go(enabling ? Step::read_plate : step_);
  if (step_ == Step::free_handle) return next_definition();
  if (enabling) return go(Step::start);
  go(listed_.size > 0 ? Step::list_uninitialised : Step::list_disabled);
}

/// Proceeds to the next tool with a definition, or to the step after the last one.
void NdiTracker::next_definition() noexcept {
  while (tool_ < params_.tools.size() && definitions_[tool_].empty()) ++tool_;
  go(tool_ < params_.tools.size() ? Step::request_handle : Step::list_uninitialised);
}

std::optional<std::size_t> NdiTracker::tool_of(std::uint8_t handle) const noexcept {
  const auto end = handles_.begin() + static_cast<std::ptrdiff_t>(params_.tools.size());
  const auto found = std::find(handles_.begin(), end, std::optional(handle));
  if (found == end) return std::nullopt;
  return static_cast<std::size_t>(found - handles_.begin());
}

ParseResult NdiTracker::parse(std::span<const std::uint8_t> content, ndi::PoseReply& reply) const noexcept {
  constexpr auto mark = ndi::ImplausiblePose::mark_handle;
  switch (poll_) {
    case Poll::bx2: return ndi::parse_bx2(content, reply, mark);
    case Poll::bx: return ndi::parse_bx(content, poll_options, reply, mark);
    case Poll::tx: break;
  }
  return ndi::parse_tx(content, poll_options, reply, mark);
}

void NdiTracker::on_poses(ndi::ReplyReceiver::Event event, std::span<const std::uint8_t> content,
                          Nanoseconds now) noexcept {
  awaiting_ = false;
  const bool binary = event == ndi::ReplyReceiver::Event::binary;
  ndi::PoseReply reply;
  if (step_ != Step::poll || binary == (poll_ == Poll::tx) || parse(content, reply) != ParseResult::ok) {
    ++report_.counters.malformed;
    return on_lost_reply(now);
  }
  on_poll_answered(now);
  const Nanoseconds t = reply.t_ns != 0 ? clock_.to_local(reply.t_ns, t_reply_) : t_reply_;
  for (const ndi::HandlePose& pose : reply.all()) take(pose, t);
  std::size_t num_enabled = 0;
  for (std::size_t i = 0; i < params_.tools.size(); ++i) {
    if (!enabled_[i]) not_measured(i, ToolState::disabled, t_reply_);
    if (enabled_[i]) ++num_enabled;
  }
  if (const char* const trouble = ndi::system_status_text(reply.system_status)) {
    enter(TrackerState::tracking, "%s", trouble);
  } else if (!was_tracking()) {
    const bool all = num_enabled == params_.tools.size();
    enter(TrackerState::tracking, "%zu of %zu tools enabled%s%s", num_enabled, params_.tools.size(),
          all ? "" : ": ",
          all                   ? ""
          : refused_[0] != '\0' ? refused_.data()
                                : "the others are not plugged in");
  }
}

void NdiTracker::take(const ndi::HandlePose& pose, Nanoseconds t) noexcept {
  const auto tool = tool_of(pose.handle);
  if (!tool) return;
  switch (pose.status) {
    case ndi::HandleStatus::valid: {
      const bool outside = (pose.port_bits & ndi::port_status::out_of_volume) != 0;
      return measured(*tool, pose.X_TH, pose.frame, pose.error_m,
                      outside ? ToolState::out_of_volume : ToolState::valid, t);
    }
    case ndi::HandleStatus::implausible: ++report_.counters.malformed; return;
    case ndi::HandleStatus::missing: return not_measured(*tool, ToolState::missing, t);
    case ndi::HandleStatus::disabled: return not_measured(*tool, ToolState::disabled, t);
  }
}

}  // namespace godobject
