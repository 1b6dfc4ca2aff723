// The client of one node's SDO server: one transfer at a time, nothing waits.
#pragma once

#include <string>

#include "hal/can/bus.h"
#include "hal/canopen/sdo/sdo.h"

namespace godobject::sdo {

enum class TransferState : std::uint8_t {
  idle,        // nothing asked for yet
  busy,        // under way: keep calling on_frame and poll
  done,        // a read's bytes are in data()
  aborted,     // by the node: abort_code() says why
  timed_out,   // no answer: node off, wrong node-ID or bit rate, or it has no SDO server
  not_sent,    // the bus has not taken the request: see its state
  bad_answer,  // the node broke the protocol: abort_code() is what it has been told
  too_large,   // a read of more than `capacity` bytes
};

/// A request whose answer stays away is repeated where that does no harm, which CiA 301 leaves to the client: the first
/// of a read, and an expedited write, which is the same done twice. A frame that is lost among segments ends as timed_out:
/// the server's toggle bit may have changed. Frames that belong to no transfer of this client are left alone, late
/// answers among them, but for one of the same kind and object as is waited for.
class Client {
 public:
  static constexpr std::size_t capacity = 256;  // bytes of a transfer
  static constexpr int max_repeats = 2;

  /// timeout: for each answer of the node, repeats of the request included.
  explicit Client(std::uint8_t node, Nanoseconds timeout_ns = 1'000'000'000) noexcept
      : node_(node), timeout_ns_(timeout_ns) {}

  /// Begin a transfer with the next poll. False, and nothing begun, while one is under way, or with no or
  /// more than `capacity` bytes to write.
  [[nodiscard]] bool read(ObjectAddress address) noexcept;
  [[nodiscard]] bool write(ObjectAddress address, std::span<const std::uint8_t> data) noexcept;

  /// True when the frame was this transfer's.
  bool on_frame(const CanFrame& frame) noexcept;
  /// Sends what is due on `bus`; watches the time-out.
  void poll(Nanoseconds now, CanBus& bus) noexcept;

  TransferState state() const noexcept { return state_; }
  bool busy() const noexcept { return state_ == TransferState::busy; }
  AbortCode abort_code() const noexcept { return abort_code_; }
  ObjectAddress address() const noexcept { return address_; }
  /// What a read that is done has read.
  std::span<const std::uint8_t> data() const noexcept { return std::span(data_).first(size_); }
  /// The same of an object whose type has type_size bytes: where the node does not indicate the size (CiA 301
  /// 7.2.4.3.6, s = 0), bytes beyond those are none of the object's.
  std::span<const std::uint8_t> data(std::size_t type_size) const noexcept {
    return data().first(size_indicated_ ? size_ : std::min(size_, type_size));
  }
  std::uint8_t node() const noexcept { return node_; }
  /// How often the transfer's first request has been repeated.
  int repeats() const noexcept { return repeats_; }
  /// What went wrong and what to check; empty unless it did. Allocates.
  std::string failure_text() const;

 private:
  enum class Expected : std::uint8_t { initiate_download, download_segment, initiate_upload, upload_segment };

  bool begin(ObjectAddress address, Expected expected, const Message& first) noexcept;
  void ask(const Message& message, Expected expected) noexcept;
  bool may_repeat() const noexcept;
  bool is_of_this_transfer(const Message& message, std::size_t size) noexcept;
  void on_upload_started(const Message& message, std::size_t size) noexcept;
  void on_upload_segment(const Message& message, std::size_t size) noexcept;
  void send_segment() noexcept;
  bool store(std::span<const std::uint8_t> bytes) noexcept;
  void finish(TransferState state, AbortCode code = AbortCode::none) noexcept;
  void give_up(TransferState state, AbortCode code) noexcept;

  std::uint8_t node_;
  Nanoseconds timeout_ns_;
  TransferState state_ = TransferState::idle;
  AbortCode abort_code_ = AbortCode::none;
  ObjectAddress address_;
  Expected expected_ = Expected::initiate_upload;
  std::array<std::uint8_t, capacity> data_{};
  std::size_t size_ = 0;      // of data_
  std::size_t position_ = 0;  // bytes of data_ that have been sent
  bool size_given_ = false;   // of segments, by the announcement
  std::uint32_t announced_size_ = 0;
  bool size_indicated_ = true;  // of what has been read
  bool toggle_ = false;

  Message message_{};       // the last one asked with
  bool must_send_ = false;  // message_ has yet to be taken by the bus
  bool timing_ = false;     // deadline_ns_ is set
  Nanoseconds deadline_ns_ = 0, repeat_ns_ = 0;
  int repeats_ = 0;
  int late_answers_ = 0;  // at most so many may still come, to requests that were repeated
  int late_aborts_ = 0;   // of them to requests of the transfer before
};

}  // namespace godobject::sdo
