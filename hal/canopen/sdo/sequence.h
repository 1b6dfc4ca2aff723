// A list of SDO transfers with one node, done one after the other: writes, checks and waits.
#pragma once

#include <string>
#include <vector>

#include "hal/canopen/sdo/client.h"

namespace godobject {

enum class SdoAction : std::uint8_t {
  write,           // low
  write_if_other,  // read, and low written where it is another
  compare,         // read; notes whether it is another than low, or not there
  skip_if_same,  // no transfer: the next `low` steps are left out if no compare since the last one has differed
  check,         // read; must lie in low..high
  wait_for,      // read, again and again, until it lies in low..high
  switch_off,    // PDO communication record, sub 1: set bit 31, keep the rest; one that is read-only stays on
  switch_off_if_there,  // the same, and no such object is fine
  switch_on,  // the same: low with bit 31 clear and bit 30 as the node has it; left out where it stayed on
};

struct SdoStep {
  SdoAction action = SdoAction::write;
  canopen::ObjectAddress address{};
  canopen::ObjectType type = canopen::ObjectType::u32;
  std::int64_t low = 0, high = 0;
  std::uint32_t ignored_bits = 0;  // of what is read
  unsigned line = 0;               // of the profile that asks for it; 0: none does
  std::string hint{};              // what to do when it fails
};

enum class SdoFailure : std::uint8_t {
  none,
  transfer,        // SdoSequence::client() says what happened
  wrong_value,     // of a check
  wrong_size,      // the object has another type
  never_the_value  // of a wait_for
};

class SdoSequence {
 public:
  static constexpr std::uint32_t pdo_invalid = 1u << 31;  // of a PDO's COB-ID (CiA 301 7.5.2)
  static constexpr std::uint32_t pdo_no_rtr = 1u << 30;
  static constexpr Nanoseconds wait_interval_ns = 10'000'000;  // between the reads of a wait_for

  /// wait_timeout: of each wait_for. Allocates; nothing later does but error_text().
  SdoSequence(std::uint8_t node, std::vector<SdoStep> steps, Nanoseconds sdo_timeout_ns,
              Nanoseconds wait_timeout_ns);

  /// True when the frame was the sequence's.
  bool on_frame(const CanFrame& frame) noexcept { return client_.on_frame(frame); }
  void poll(Nanoseconds now, CanBus& bus) noexcept;
  /// From the first step on again, whatever became of it. A request under way is forgotten.
  void restart() noexcept;

  bool done() const noexcept { return current_ == steps_.size(); }
  bool failed() const noexcept { return failure_ != SdoFailure::none; }
  SdoFailure failure() const noexcept { return failure_; }
  const sdo::Client& client() const noexcept { return client_; }
  /// The step under way or failed; null when done.
  const SdoStep* step() const noexcept { return done() ? nullptr : &steps_[current_]; }
  const std::vector<SdoStep>& steps() const noexcept { return steps_; }

  /// "6060h:00 <- 10 rejected: 06090030 invalid value ..."; empty unless failed().
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
  bool begun_ = false;           // the current step's first transfer has been asked for
  bool writing_ = false;         // the transfer under way is a write
  std::int64_t read_value_ = 0;  // of the last read, without the ignored bits
  std::int64_t written_value_ = 0;
  std::uint32_t cob_id_flags_ = 0;  // bit 30 as last read by switch_off
  bool differs_ = false;            // a compare since the last skip_if_same
  bool stayed_on_ = false;          // the last switch_off could not be written
  Nanoseconds wait_began_ns_ = 0, read_again_ns_ = 0;
};

/// "6060h:00".
std::string to_string(canopen::ObjectAddress address);

}  // namespace godobject
