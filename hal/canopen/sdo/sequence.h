// A list of SDO transfers with one node, executed in order: writes, checks and waits.
#pragma once

#include <string>
#include <vector>

#include "hal/canopen/sdo/client.h"

namespace godobject {

enum class SdoAction : std::uint8_t {
  write,           // writes low
  write_if_other,  // reads; writes low if the value differs
  compare,         // reads; records whether the value differs from low or the object is missing
  // no transfer; skips the next `low` steps if no compare since the last skip_if_same has differed
  skip_if_same,
  check,       // reads; the value must be in low..high
  wait_for,    // reads repeatedly until the value is in low..high
  switch_off,  // PDO communication record, sub 1: sets bit 31, keeps the rest; a read-only one stays on
  switch_off_if_there,  // as switch_off; a missing object is accepted
  // PDO communication record, sub 1: low with bit 31 clear, bit 30 as in the node; skipped if it stayed on
  switch_on,
};

struct SdoStep {
  SdoAction action = SdoAction::write;
  canopen::ObjectAddress address{};
  canopen::ObjectType type = canopen::ObjectType::u32;
  std::int64_t low = 0, high = 0;
  std::uint32_t ignored_bits = 0;  // bits of the read value that are ignored
  unsigned line = 0;               // line of the profile that requires the step; 0: none
  std::string hint{};              // remedy if the step fails
};

enum class SdoFailure : std::uint8_t {
  none,
  transfer,        // details in SdoSequence::client()
  wrong_value,     // value outside the range of a check
  wrong_size,      // the object has another type
  never_the_value  // a wait_for timed out
};

class SdoSequence {
 public:
  static constexpr std::uint32_t pdo_invalid = 1u << 31;  // bit of a PDO's COB-ID (CiA 301 7.5.2)
  static constexpr std::uint32_t pdo_no_rtr = 1u << 30;
  static constexpr Nanoseconds wait_interval_ns = 10'000'000;  // interval between the reads of a wait_for

  /// sdo_timeout_ns: limit per transfer. wait_timeout_ns: limit of each wait_for, ns. Allocates; afterwards
  /// only error_text() does.
  SdoSequence(std::uint8_t node, std::vector<SdoStep> steps, Nanoseconds sdo_timeout_ns,
              Nanoseconds wait_timeout_ns);

  /// Processes a frame. Returns true if it belongs to the sequence.
  bool on_frame(const CanFrame& frame) noexcept { return client_.on_frame(frame); }
  void poll(Nanoseconds now, CanBus& bus) noexcept;
  /// Restarts at the first step, in any state. Drops a running request.
  void restart() noexcept;

  bool done() const noexcept { return current_ == steps_.size(); }
  bool failed() const noexcept { return failure_ != SdoFailure::none; }
  SdoFailure failure() const noexcept { return failure_; }
  const sdo::Client& client() const noexcept { return client_; }
  /// Returns the running or failed step; null when done.
  const SdoStep* step() const noexcept { return done() ? nullptr : &steps_[current_]; }
  const std::vector<SdoStep>& steps() const noexcept { return steps_; }

  /// Returns "6060h:00 <- 10 rejected: 06090030 invalid value ..."; empty unless failed().
  std::string error_text() const;

 private:
  void begin(Nanoseconds now) noexcept;
  void skip_what_is_right() noexcept;
  void write(std::int64_t value) noexcept;
  void finish_transfer(Nanoseconds now) noexcept;
  void on_read(Nanoseconds now) noexcept;
  void next() noexcept;

  sdo::Client client_;
  Nanoseconds sdo_timeout_ns_;
  std::vector<SdoStep> steps_;
  Nanoseconds wait_timeout_ns_;
  std::size_t current_ = 0;
  SdoFailure failure_ = SdoFailure::none;
  bool begun_ = false;           // the first transfer of the current step was requested
  bool writing_ = false;         // the running transfer is a write
  std::int64_t read_value_ = 0;  // last value read, without the ignored bits
  std::int64_t written_value_ = 0;
  std::uint32_t cob_id_flags_ = 0;  // bit 30 as last read by switch_off
  bool differs_ = false;            // a compare since the last skip_if_same found a difference
  bool stayed_on_ = false;          // the last switch_off was rejected by the node
  Nanoseconds wait_began_ns_ = 0, read_again_ns_ = 0;
};

/// Formats an address as "6060h:00".
std::string to_string(canopen::ObjectAddress address);

}  // namespace godobject
