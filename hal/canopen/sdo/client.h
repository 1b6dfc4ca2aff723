// Client of one node's SDO server: one transfer at a time, non-blocking.
#pragma once

#include <string>

#include "hal/can/bus.h"
#include "hal/canopen/sdo/sdo.h"

namespace godobject::sdo {

enum class TransferState : std::uint8_t {
  idle,        // no transfer requested yet
  busy,        // transfer running: keep calling on_frame and poll
  done,        // complete; data() holds the bytes of a read
  aborted,     // aborted by the node with abort_code()
  timed_out,   // no answer: node off, wrong node-ID or bit rate, or it has no SDO server
  not_sent,    // the bus did not accept the request: see its state
  bad_answer,  // the node broke the protocol; the client aborted with abort_code()
  too_large,   // read of more than `capacity` bytes
};

/// Repeats an unanswered request if repeating is harmless, as CiA 301 permits: the first request of a read,
/// and an expedited write, which is idempotent. A frame lost among segments ends as timed_out, because the
/// server's toggle bit may have changed. Ignores frames of other transfers, including late answers, except
/// one of the expected kind and object.
class Client {
 public:
  static constexpr std::size_t capacity = 256;  // bytes per transfer
  static constexpr int max_repeats = 2;

  /// timeout_ns: limit for each answer of the node, including repeats of the request, ns.
  explicit Client(std::uint8_t node, Nanoseconds timeout_ns = 1'000'000'000) noexcept
      : node_(node), timeout_ns_(timeout_ns) {}

  /// Begin a transfer at the next poll. Return false and begin nothing while a transfer runs. write() also
  /// returns false for 0 or more than `capacity` bytes.
  [[nodiscard]] bool read(ObjectAddress address) noexcept;
  [[nodiscard]] bool write(ObjectAddress address, std::span<const std::uint8_t> data) noexcept;

  /// Processes a frame. Returns true if it belongs to this transfer.
  bool on_frame(const CanFrame& frame) noexcept;
  /// Sends due requests on `bus` and checks the timeout.
  void poll(Nanoseconds now, CanBus& bus) noexcept;

  TransferState state() const noexcept { return state_; }
  bool busy() const noexcept { return state_ == TransferState::busy; }
  AbortCode abort_code() const noexcept { return abort_code_; }
  ObjectAddress address() const noexcept { return address_; }
  /// Returns the bytes of a completed read.
  std::span<const std::uint8_t> data() const noexcept { return std::span(data_).first(size_); }
  /// Returns the bytes of a completed read of an object with type_size bytes. If the node does not indicate
  /// the size (CiA 301 7.2.4.3.6, s = 0), bytes beyond type_size are padding.
  std::span<const std::uint8_t> data(std::size_t type_size) const noexcept {
    return data().first(size_indicated_ ? size_ : std::min(size_, type_size));
  }
  std::uint8_t node() const noexcept { return node_; }
  /// Returns the number of repeats of the transfer's first request.
  int repeats() const noexcept { return repeats_; }
  /// Returns the failure and its remedy; empty if the transfer did not fail. Allocates.
  std::string failure_text() const;

 private:
  enum class Expected : std::uint8_t { initiate_download, download_segment, initiate_upload, upload_segment };

  bool begin(ObjectAddress address, Expected expected, const Message& first) noexcept;
  void request(const Message& message, Expected expected) noexcept;
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
  std::size_t size_ = 0;      // bytes used in data_
  std::size_t position_ = 0;  // bytes of data_ already sent
  bool size_given_ = false;   // the announcement gave the size of a segmented transfer
  std::uint32_t announced_size_ = 0;
  bool size_indicated_ = true;  // the node indicated the size of the read data
  bool toggle_ = false;

  Message message_{};       // last request
  bool must_send_ = false;  // the bus has not accepted message_ yet
  bool timing_ = false;     // deadline_ns_ is set
  Nanoseconds deadline_ns_ = 0, repeat_ns_ = 0;
  int repeats_ = 0;
  int late_answers_ = 0;  // number of answers to repeated requests that may still arrive
  int late_aborts_ = 0;   // number of late aborts that may answer requests of the previous transfer
};

}  // namespace godobject::sdo
