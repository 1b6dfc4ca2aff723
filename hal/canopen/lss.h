// Layer setting services (CiA 305): sets node-ID and bit rate of a node over the bus and lists the nodes.
// Fast scan is not supported.
#pragma once

#include <optional>

#include "hal/can/bus.h"
#include "hal/canopen/message.h"

namespace godobject::lss {

inline constexpr std::uint32_t request_cob_id = 0x7E5;   // master to slaves
inline constexpr std::uint32_t response_cob_id = 0x7E4;  // slave to master

enum class Command : std::uint8_t {
  switch_global = 0x04,
  set_node_id = 0x11,
  set_bit_timing = 0x13,
  activate_bit_timing = 0x15,
  store = 0x17,
  select_vendor = 0x40,
  select_product = 0x41,
  select_revision = 0x42,
  select_serial = 0x43,
  selected = 0x44,  // the slave's answer to the four selections
  inquire_vendor = 0x5A,
  inquire_product = 0x5B,
  inquire_revision = 0x5C,
  inquire_serial = 0x5D,
  inquire_node_id = 0x5E,
};

enum class Mode : std::uint8_t { waiting = 0, configuration = 1 };

/// Identity object 1018h, which selects one node of many.
struct Identity {
  std::uint32_t vendor = 0, product = 0, revision = 0, serial = 0;
};

using canopen::make_frame;
using canopen::Message;
using canopen::parse_frame;

constexpr Message make_message(Command command, std::uint8_t first = 0, std::uint8_t second = 0) noexcept {
  return {static_cast<std::uint8_t>(command), first, second};
}
constexpr Message make_select(Command command, std::uint32_t value) noexcept {
  Message message{};
  ByteWriter(message).put(static_cast<std::uint8_t>(command)).put(value);
  return message;
}
/// Makes activate bit timing. delay_ms: silence before and again after the nodes change their bit rate, ms.
constexpr Message make_activate(std::uint16_t delay_ms) noexcept {
  Message message{};
  ByteWriter(message).put(static_cast<std::uint8_t>(Command::activate_bit_timing)).put(delay_ms);
  return message;
}

/// Returns the index in table 0 of CiA 305. 100 kbit/s is index 5 in older issues, reserved in newer ones,
/// therefore not supported.
constexpr std::optional<std::uint8_t> bit_timing_index(double bit_rate) noexcept {
  constexpr std::array rates{1e6, 800e3, 500e3, 250e3, 125e3, 0.0, 50e3, 20e3, 10e3};
  for (std::size_t i = 0; i < rates.size(); ++i)
    if (rates[i] == bit_rate && bit_rate > 0) return static_cast<std::uint8_t>(i);
  return std::nullopt;
}

enum class Outcome : std::uint8_t {
  idle,
  busy,
  done,
  rejected,   // rejected by the slave with error_code()
  no_answer,  // no node in configuration mode: off, other bit rate, or without LSS
  not_sent,   // the bus did not accept the request
};

/// Returns the meaning of an error code of set node-ID, set bit timing or store.
const char* text_of(Command command, std::uint8_t error_code) noexcept;

/// LSS master: one service at a time, non-blocking. Switch global addresses every node. To set node-ID or bit
/// rate, exactly one node may be on the bus or be selected by its identity.
class Master {
 public:
  explicit Master(Nanoseconds timeout_ns = 1'000'000'000) noexcept : timeout_ns_(timeout_ns) {}

  // Each begins at the next poll. Returns false and begins nothing while another service runs.
  /// Switches the mode of all nodes. Has no answer: done once sent.
  [[nodiscard]] bool switch_global(Mode mode) noexcept;
  [[nodiscard]] bool select(const Identity& identity) noexcept;
  /// Sets the node-ID. node_id: 1..127, or 255 for none.
  [[nodiscard]] bool set_node_id(std::uint8_t node_id) noexcept;
  [[nodiscard]] bool set_bit_timing(std::uint8_t index) noexcept;
  [[nodiscard]] bool store() noexcept;
  /// Sends an inquire_... command to all nodes in configuration mode. Busy until the timeout, then done with
  /// their answers(), or no_answer.
  [[nodiscard]] bool inquire(Command command) noexcept;
  /// Activates the bit timing. Has no answer: done once sent.
  [[nodiscard]] bool activate_bit_timing(std::uint16_t delay_ms) noexcept;

  bool on_frame(const CanFrame& frame) noexcept;
  void poll(Nanoseconds now, CanBus& bus) noexcept;

  Outcome outcome() const noexcept { return outcome_; }
  std::uint8_t error_code() const noexcept { return error_code_; }
  std::uint8_t vendor_error() const noexcept { return vendor_error_; }  // valid if error_code() is 255
  /// Returns the answers to inquire(), one per node, in order of arrival, at most 127.
  std::span<const std::uint32_t> answers() const noexcept { return std::span(answers_).first(num_answers_); }

 private:
  bool begin(std::span<const Message> messages, std::optional<Command> answer) noexcept;

  Nanoseconds timeout_ns_;
  std::array<Message, 4> messages_{};
  std::size_t count_ = 0, sent_ = 0;
  std::optional<Command> answer_;
  Outcome outcome_ = Outcome::idle;
  std::uint8_t error_code_ = 0, vendor_error_ = 0;
  std::array<std::uint32_t, canopen::max_node_id> answers_{};
  std::size_t num_answers_ = 0;
  bool inquires_ = false;
  bool timing_ = false;
  Nanoseconds deadline_ns_ = 0;
};

}  // namespace godobject::lss
