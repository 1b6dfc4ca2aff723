#include "hal/canopen/sdo/client.h"

#include <cstdio>

namespace godobject::sdo {

namespace {

constexpr std::size_t address_end = 4;  // command, index, sub-index

}  // namespace

bool Client::read(ObjectAddress address) noexcept {
  if (busy()) return false;
  size_ = 0;
  return begin(address, Expected::initiate_upload, make_plain(Request::initiate_upload, address));
}

bool Client::write(ObjectAddress address, std::span<const std::uint8_t> data) noexcept {
  if (busy() || data.empty() || data.size() > capacity) return false;
  std::ranges::copy(data, data_.begin());
  size_ = data.size();
  const Message first =
      size_ <= expedited_capacity
          ? make_expedited(Request::initiate_download, address, data)
          : make_announcement(Request::initiate_download, address, static_cast<std::uint32_t>(size_));
  return begin(address, Expected::initiate_download, first);
}

bool Client::begin(ObjectAddress address, Expected expected, const Message& first) noexcept {
  address_ = address;
  abort_code_ = AbortCode::none;
  position_ = 0;
  toggle_ = false;
  late_answers_ = repeats_;
  late_aborts_ = repeats_;
  repeats_ = 0;
  state_ = TransferState::busy;
  request(first, expected);
  return true;
}

void Client::request(const Message& message, Expected expected) noexcept {
  message_ = message;
  expected_ = expected;
  must_send_ = true;
  timing_ = false;
}

bool Client::may_repeat() const noexcept {
  const bool read = expected_ == Expected::initiate_upload;
  const bool expedited_write = expected_ == Expected::initiate_download && size_ <= expedited_capacity;
  return (read || expedited_write) && repeats_ < max_repeats;
}

void Client::poll(Nanoseconds now, CanBus& bus) noexcept {
  constexpr int max_requests = 1 + max_repeats;
  if (busy() && !timing_) {
    timing_ = true;
    deadline_ns_ = now + timeout_ns_;
    repeat_ns_ = now + timeout_ns_ / max_requests;
  }
  if (busy() && !must_send_ && may_repeat() && now >= repeat_ns_ && now < deadline_ns_) {
    ++repeats_;
    ++late_answers_;
    must_send_ = true;
    repeat_ns_ = now + timeout_ns_ / max_requests;
  }
  if (must_send_)
    must_send_ = bus.try_send(make_frame(request_cob_id(node_), message_)) != SendResult::queued;
  if (!busy() || now < deadline_ns_) return;
  if (must_send_) {
    must_send_ = false;
    finish(TransferState::not_sent);
  } else {
    // The server may be within its transfer: the next poll sends the abort.
    give_up(TransferState::timed_out, AbortCode::timed_out);
  }
}

// True if the message answers this transfer. Some servers abort with index 0. A message without a whole
// address answers a segment or is an abort.
bool Client::is_of_this_transfer(const Message& message, std::size_t size) noexcept {
  const bool is_abort = command_of(message) == static_cast<std::uint8_t>(Response::abort);
  const bool initiating = expected_ == Expected::initiate_download || expected_ == Expected::initiate_upload;
  if (!is_abort && !initiating) return true;
  if (!is_abort && size < address_end) return false;
  if (address_of(message) == address_) return true;
  if (!is_abort || address_of(message) != ObjectAddress{}) return false;
  if (late_aborts_ == 0) return true;
  --late_aborts_;
  return false;
}

bool Client::on_frame(const CanFrame& frame) noexcept {
  Message message;
  std::size_t size = 0;
  const bool initiating = expected_ == Expected::initiate_download || expected_ == Expected::initiate_upload;
  const bool requested = !must_send_ || (initiating && repeats_ > 0);
  if (!busy() || !requested || parse_response(frame, node_, message, size) != ParseResult::ok) return false;
  const auto response = static_cast<Response>(command_of(message));
  if (!is_of_this_transfer(message, size)) return false;  // late answer to an earlier transfer
  must_send_ = false;                                     // cancels a repeat not yet sent
  if (response == Response::abort) {
    finish(TransferState::aborted, abort_code_of(message));
    return true;
  }
  static constexpr std::array expected_response{Response::initiate_download, Response::download_segment,
                                                Response::initiate_upload, Response::upload_segment};
  const bool first = response == Response::initiate_upload || response == Response::initiate_download;
  if (response != expected_response[static_cast<std::size_t>(expected_)]) {
    if (first && late_answers_ > 0) {
      --late_answers_;
      return true;
    }
    give_up(TransferState::bad_answer, AbortCode::unknown_command);
  } else if (!initiating && toggle_of(message) != toggle_) {
    give_up(TransferState::bad_answer, AbortCode::toggle_not_alternated);
  } else if (expected_ == Expected::initiate_upload) {
    on_upload_started(message, size);
  } else if (expected_ == Expected::upload_segment) {
    on_upload_segment(message, size);
  } else {
    if (expected_ == Expected::download_segment) toggle_ = !toggle_;
    send_segment();
  }
  return true;
}

// Sends the next segment of a download; the server has accepted the data up to position_.
void Client::send_segment() noexcept {
  if (size_ <= expedited_capacity || position_ == size_) {
    finish(TransferState::done);
    return;
  }
  const std::size_t count = std::min(segment_capacity, size_ - position_);
  const auto bytes = std::span<const std::uint8_t>(data_).subspan(position_, count);
  position_ += count;
  request(make_segment(Request::download_segment, toggle_, position_ == size_, bytes),
          Expected::download_segment);
}

void Client::on_upload_started(const Message& message, std::size_t size) noexcept {
  const Initiation initiation = initiation_of(message);
  const std::size_t present = size - address_end;
  if (initiation.expedited) {
    const std::span<const std::uint8_t> data = expedited_data(message);
    size_indicated_ = initiation.size_given;
    if (present == 0 || (size_indicated_ && present < data.size())) {
      give_up(TransferState::bad_answer, AbortCode::wrong_length);
      return;
    }
    static_cast<void>(store(data.first(std::min(data.size(), present))));
    finish(TransferState::done);
    return;
  }
  size_given_ = initiation.size_given && present == expedited_capacity;
  announced_size_ = initiation.size;
  if (size_given_ && announced_size_ > capacity) {
    give_up(TransferState::too_large, AbortCode::out_of_memory);
    return;
  }
  request(make_turn(Request::upload_segment, toggle_), Expected::upload_segment);
}

void Client::on_upload_segment(const Message& message, std::size_t size) noexcept {
  const std::span<const std::uint8_t> data = segment_data(message);
  // True also if the message does not indicate the size of its data.
  const bool whole = data.size() == segment_capacity;
  if (!whole && size - 1 < data.size()) {
    give_up(TransferState::bad_answer, AbortCode::wrong_length);
    return;
  }
  size_indicated_ = size_given_ || !whole;
  if (!store(data.first(std::min(data.size(), size - 1)))) {
    give_up(TransferState::too_large, AbortCode::out_of_memory);
    return;
  }
  const bool last = is_last_segment(message);
  const bool too_many = size_given_ && size_ > announced_size_;
  const bool too_few = size_given_ && last && size_ < announced_size_;
  if (too_many || too_few) {
    give_up(TransferState::bad_answer, AbortCode::wrong_length);
  } else if (last) {
    finish(TransferState::done);
  } else {
    toggle_ = !toggle_;
    request(make_turn(Request::upload_segment, toggle_), Expected::upload_segment);
  }
}

bool Client::store(std::span<const std::uint8_t> bytes) noexcept {
  if (bytes.size() > capacity - size_) return false;
  std::ranges::copy(bytes, data_.begin() + static_cast<std::ptrdiff_t>(size_));
  size_ += bytes.size();
  return true;
}

void Client::finish(TransferState state, AbortCode code) noexcept {
  state_ = state;
  abort_code_ = code;
}

void Client::give_up(TransferState state, AbortCode code) noexcept {
  finish(state, code);
  message_ = make_abort(address_, code);
  must_send_ = true;
}

std::string Client::failure_text() const {
  std::array<char, 16> code{};
  std::snprintf(code.data(), code.size(), "%08X ", static_cast<unsigned>(abort_code_));
  const std::string ms = std::to_string(timeout_ns_ / 1'000'000) + " ms";
  switch (state_) {
    case TransferState::aborted: return std::string("rejected: ") + code.data() + text_of(abort_code_);
    case TransferState::timed_out:
      return "no answer within " + ms +
             (repeats_ == 0 ? "" : " to " + std::to_string(1 + repeats_) + " requests") +
             ": check that the node is powered and not stopped, that its node-ID is right and unique, and "
             "the bit rate and both terminations of the bus";
    case TransferState::not_sent:
      return "the bus did not accept the request within " + ms +
             ": check that another node acknowledges at this bit rate";
    case TransferState::bad_answer:
      return std::string("the answer violates the protocol: ") + code.data() + text_of(abort_code_);
    case TransferState::too_large: return "the object has more than " + std::to_string(capacity) + " bytes";
    case TransferState::idle:
    case TransferState::busy:
    case TransferState::done: break;
  }
  return "";
}

}  // namespace godobject::sdo
