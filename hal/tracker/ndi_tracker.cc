#include "hal/tracker/ndi_tracker.h"

#include <algorithm>

#include "hal/tracker/address.h"

namespace godobject {
namespace {

constexpr Nanoseconds ms = 1'000'000;
constexpr Nanoseconds reset_patience = 2500 * ms;
constexpr Nanoseconds setup_patience = 5000 * ms;  // INIT and PINIT take seconds on some trackers
constexpr Nanoseconds max_poll_patience = 500 * ms;
constexpr Nanoseconds poll_margin = 3 * ms;  // separates a late reply from a lost one
constexpr Nanoseconds poll_silence = 1500 * ms;
constexpr Nanoseconds rate_change_pause =
    200 * ms;                                // after a change of the bit rate; the API requires 100 ms
constexpr Nanoseconds quiet = 8 * ms;        // after a broken reply: its rest may follow
constexpr Nanoseconds max_quiet = 300 * ms;  // longest reply at 9600 bit/s
constexpr Nanoseconds poll_period = 1 * ms;  // minimum: avoids flooding a fast line
constexpr Nanoseconds retry_period = 5000 * ms;

constexpr std::array step_names{"slow down", "break", "COMM",   "set rate", "INIT",  "PHSR:01",
                                "PHF",       "PHRQ",  "PVWR",   "PHSR:02",  "PINIT", "PHSR:03",
                                "PHINF",     "PENA",  "TSTART", "poll"};

std::optional<unsigned> hex_digit(char c) noexcept {
  if (c >= '0' && c <= '9') return static_cast<unsigned>(c - '0');
  if (c >= 'A' && c <= 'F') return static_cast<unsigned>(c - 'A' + 10);
  return std::nullopt;
}

}  // namespace

std::optional<std::uint8_t> ndi_handle(std::string_view tool) noexcept {
  if (tool.size() != 2) return std::nullopt;
  const auto high = hex_digit(tool[0]), low = hex_digit(tool[1]);
  if (!high || !low) return std::nullopt;
  return static_cast<std::uint8_t>(*high << 4 | *low);
}

const char* NdiTracker::name_of(Step step) noexcept { return step_names[static_cast<std::size_t>(step)]; }

std::unique_ptr<Tracker> make_ndi_tracker(const TrackerParams& params, ToolDefinitions definitions,
                                          std::vector<std::string>& errors) {
  const std::string where = "tracker '" + params.name + "': ";
  if (!is_on_network(params) && !ndi::comm_digit(params.baud))
    errors.push_back(where + "no NDI tracker supports " + std::to_string(params.baud) +
                     " bit/s: choose 9600, 14400, 19200, 38400, 57600, 115200, 230400, 921600 or 1228739");
  for (std::size_t i = 0; i < params.tools.size(); ++i) {
    const std::string& tool = params.tools[i].tool;
    if (!ndi_handle(tool) && (definitions[i].empty() || definitions[i].size() > 0x10000))
      errors.push_back(where + "tool '" + tool +
                       "' is neither the two digits of a port handle nor a readable tool definition file");
  }
  if (!errors.empty()) return nullptr;
  return std::make_unique<NdiTracker>(params, std::move(definitions));
}

NdiTracker::NdiTracker(const TrackerParams& params, ToolDefinitions definitions)
    : Tracker(params), definitions_(std::move(definitions)) {
  for (std::size_t i = 0; i < params_.tools.size(); ++i) {
    if (definitions_[i].empty()) handles_[i] = ndi_handle(params_.tools[i].tool);
  }
}

void NdiTracker::opened(Nanoseconds now) noexcept {
  plain_start_ = false;
  poll_ = is_on_network(params_) ? Poll::bx2 : Poll::bx;
  clock_ = {};
  by_default_rate_ = true;
  boot_deadline_ = now + std::llround(params_.boot_timeout_s * 1e9);
  restart(now);
}

/// Restarts the initialisation without changing the line.
void NdiTracker::restart(Nanoseconds now) noexcept {
  for (std::size_t i = 0; i < params_.tools.size(); ++i) {
    if (!definitions_[i].empty()) handles_[i].reset();
  }
  enabled_ = {};
  refused_[0] = '\0';
  tool_ = address_ = 0;
  longest_answer_ = 0;
  passes_ = 0;
  unread_.clear();
  go(is_on_network(params_) ? Step::initialise : by_default_rate_ ? Step::slow_down : Step::follow_rate);
  not_before_ = now;
  if (report_.state != TrackerState::failed)
    enter(TrackerState::initialising, "resetting the tracker on %.60s", params_.port.c_str());
}

/// Handles a failed attempt. The next attempt begins at the other rate, the default or the configured one: a
/// line without breaks (USB, network) keeps its rate.
void NdiTracker::give_up_or_restart(const char* why, Nanoseconds now) noexcept {
  if (was_tracking()) {
    ++report_.counters.restarts;
    boot_deadline_ = now + std::llround(params_.boot_timeout_s * 1e9);
  }
  by_default_rate_ = !by_default_rate_ || was_tracking();
  const Step at = step_;
  if (now < boot_deadline_) {
    report_.state = TrackerState::initialising;
    restart(now);
    enter(TrackerState::initialising, "%s: %s; trying again", name_of(at), why);
    return;
  }
  enter(TrackerState::failed, "%s: %s; retried every 5 s", name_of(at), why);
  restart(now);
  not_before_ = now + retry_period;
}

/// Returns a description of the bytes received instead of a reply, or `otherwise` if there were none.
const char* NdiTracker::unread_or(const char* otherwise) noexcept {
  if (unread_.empty()) return otherwise;
  unread_.describe(TrackerProtocol::ndi, params_.baud, unread_text_);
  return unread_text_.data();
}

void NdiTracker::go(Step step) noexcept {
  step_ = step;
  tries_ = 0;
  awaiting_ = false;
}

ndi::Command NdiTracker::command() const noexcept {
  const std::uint8_t handle = at_ < listed_.size ? listed_.handles[at_].handle : std::uint8_t{0};
  switch (step_) {
    case Step::set_rate: {
      const std::array<char, 5> rate{*ndi::comm_digit(params_.baud), '0', '0', '0', '0'};
      return ndi::make_command("COMM", {rate.data(), rate.size()});
    }
    case Step::initialise: return ndi::make_command("INIT", "");
    case Step::list_used: return ndi::make_command("PHSR", "01");
    case Step::free_handle: return ndi::make_handle_command("PHF", handle);
    case Step::request_handle: return ndi::make_command("PHRQ", "*********1****");  // any passive tool
    case Step::write_definition:
      return ndi::make_write_command(*handles_[tool_], address_, definitions_[tool_]);
    case Step::list_uninitialised: return ndi::make_command("PHSR", "02");
    case Step::initialise_handle: return ndi::make_handle_command("PINIT", handle);
    case Step::list_disabled: return ndi::make_command("PHSR", "03");
    case Step::read_plate: return ndi::make_handle_command("PHINF", handle, "0001");
    case Step::enable_handle:
      return ndi::make_handle_command("PENA", handle, "D");  // a moving tool
    // frames counted from zero
    case Step::start: return ndi::make_command("TSTART", plain_start_ ? "" : "80");
    case Step::poll:
      if (poll_ == Poll::bx2) return ndi::make_command("BX2", "--6d=tools");
      return ndi::make_command(poll_ == Poll::tx ? "TX" : "BX", "0801");
    default: return {};
  }
}

Nanoseconds NdiTracker::patience() const noexcept {
  if (step_ == Step::send_break) return reset_patience;
  return step_ == Step::poll ? poll_patience() : setup_patience;
}

/// Returns the timeout of a poll, derived from earlier replies. They contain the transfer time of command and
/// reply and the tracker's own time, which on some trackers lasts until a measurement ends. A later reply
/// counts as lost, and the poll is repeated at once; after several consecutive losses, less and less often.
Nanoseconds NdiTracker::poll_patience() const noexcept {
  constexpr int eager_tries = 4;
  if (longest_answer_ == 0) return max_poll_patience;
  const Nanoseconds soon = longest_answer_ + longest_answer_ / 4 + poll_margin;
  return std::min(soon << std::clamp(tries_ - eager_tries, 0, 6), max_poll_patience);
}

LineRequest NdiTracker::send(Nanoseconds now) noexcept {
  receiver_.reset();
  awaiting_ = true;
  reply_began_ = false;
  deadline_ = now + patience();
  if (tries_ == 0) {
    num_unanswered_ = 0;
    t_first_polled_ = now;
  }
  ++num_unanswered_;
  t_polled_ = now;
  ++tries_;
  if (step_ == Step::send_break) return {.kind = LineRequest::Kind::serial_break};
  command_ = command();
  not_before_ = now + poll_period;
  return {.kind = LineRequest::Kind::send, .bytes = command_.bytes()};
}

LineRequest NdiTracker::next(Nanoseconds now) noexcept {
  expire(now);
  if (awaiting_ && now >= deadline_) on_silence(now);
  if (awaiting_ || now < not_before_) return {};
  switch (step_) {
    case Step::slow_down:
      go(Step::send_break);
      return {.kind = LineRequest::Kind::set_baud, .baud = ndi::default_baud};
    case Step::follow_rate:
      go(Step::initialise);
      not_before_ = now + rate_change_pause;
      return {.kind = LineRequest::Kind::set_baud, .baud = params_.baud};
    default: return send(now);
  }
}

void NdiTracker::on_silence(Nanoseconds now) noexcept {
  awaiting_ = false;
  if (step_ == Step::send_break) {
    go(Step::set_rate);  // the tracker may have ignored the break but still respond
    return;
  }
  if (step_ == Step::poll && tries_ == 0) return;  // two polls were sent and one was answered
  ++report_.counters.timeouts;
  if (step_ == Step::poll && now - t_first_polled_ < poll_silence) return;
  const int allowed = step_ == Step::set_rate || step_ == Step::initialise ? 1 : max_tries;
  if (tries_ >= allowed)
    give_up_or_restart(
        unread_or("no reply: check that the tracker is switched on and connected to this port"), now);
}

/// Handles the answer to a poll. A repeated poll may be answered twice: its second answer is awaited,
/// otherwise it would be attributed to the next poll. If all answers arrive, none was lost: the reply time is
/// that of the first.
void NdiTracker::on_poll_answered(Nanoseconds now) noexcept {
  if (tries_ == 1) longest_answer_ -= (longest_answer_ - (now - t_polled_)) / 64;
  if (tries_ > 0) answer_time_ = now - t_first_polled_;
  tries_ = 0;
  awaiting_ = --num_unanswered_ > 0;
  reply_began_ = false;
  if (awaiting_) deadline_ = std::max(deadline_, t_polled_ + answer_time_ + poll_margin);
  else longest_answer_ = std::max(longest_answer_, answer_time_);
}

void NdiTracker::on_lost_reply(Nanoseconds now) noexcept {
  awaiting_ = false;
  not_before_ = now + quiet;
  quiet_until_ = now + max_quiet;
  if (step_ == Step::send_break) return go(Step::set_rate);
  if (report_.state == TrackerState::initialising)
    enter(TrackerState::initialising, "%s: %s", name_of(step_), unread_or("replies are not readable"));
  if (step_ == Step::poll) {
    tries_ = 0;  // the tracker does answer
  } else if (tries_ >= max_tries) {
    give_up_or_restart(unread_or("replies are not readable: check cable and baud"), now);
  }
}

void NdiTracker::receive(std::span<const std::uint8_t> bytes, Nanoseconds now) noexcept {
  using Event = ndi::ReplyReceiver::Event;
  unread_.add(bytes);
  for (const std::uint8_t byte : bytes) {
    if (awaiting_ && !reply_began_) t_reply_ = now;
    reply_began_ = true;
    // the reply is arriving
    if (awaiting_ && step_ == Step::poll) deadline_ = std::max(deadline_, now + poll_margin);
    if (!awaiting_ && now < quiet_until_) not_before_ = std::max(not_before_, now + quiet);
    const Event event = receiver_.push(byte);
    if (event == Event::text || event == Event::binary) unread_.clear();
    if (event == Event::more || !awaiting_) continue;
    if (event == Event::bad_crc || event == Event::too_long) {
      ++report_.counters.bad_crc;
      on_lost_reply(now);
    } else if (event == Event::binary) {
      on_poses(event, receiver_.content(), now);
    } else {
      on_text(receiver_.content(), now);
    }
  }
}

}  // namespace godobject
