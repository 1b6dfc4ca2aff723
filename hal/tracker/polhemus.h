// Binary records of Polhemus trackers: Fastrak (32 bytes), Liberty and Patriot (41, or 45 with a button). There is no
// CRC: a record is known by its first bytes, its last one, and a quaternion of unit length. A change of a few low bits
// of a position on the wire cannot be seen here; the tracker bounds it by the speed of a hand.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/math/types.h"
#include "hal/base/codec.h"

namespace godobject::polhemus {

enum class Model : std::uint8_t { fastrak, liberty };

struct Record {
  Model model = Model::fastrak;
  std::uint8_t station = 1;  // from 1
  char error = ' ';          // ' ': none; else a letter of the manual's table
  Pose X_TH{};               // the sensor in the frame of its source; inches on the wire
  std::uint32_t t_ms = 0;    // Liberty: its clock
};

inline constexpr std::size_t fastrak_size = 32;
inline constexpr std::size_t liberty_header = 8;
inline constexpr std::size_t liberty_payload = 33;         // position, quaternion, time, space
inline constexpr std::size_t liberty_button_payload = 37;  // with the button's 32 bits before the space
inline constexpr std::size_t max_record_size = liberty_header + liberty_button_payload;
inline constexpr std::size_t max_fastrak_stations = 4;
inline constexpr std::size_t max_stations = 16;

/// A record as it goes on the wire, Liberty's without a button. Empty when `out` is too small.
[[nodiscard]] std::span<const std::uint8_t> make_record(const Record& record,
                                                        std::span<std::uint8_t> out) noexcept;

/// From the first byte of a record on. `too_short`: it may be one, more bytes are needed. `size` is set on
/// `ok`, and on `bad_value`, where 0 means that no record ends where this one should.
[[nodiscard]] ParseResult parse_record(std::span<const std::uint8_t> bytes, Record& out,
                                       std::size_t& size) noexcept;

/// Takes records out of the stream; in step again at the next record after a broken one.
class RecordReceiver {
 public:
  enum class Event : std::uint8_t {
    more,
    record,     // record() is new
    malformed,  // a record without a pose; or no record: out of step, reported once until the next record
  };
  Event push(std::uint8_t byte) noexcept;
  const Record& record() const noexcept { return record_; }
  void reset() noexcept { size_ = 0, in_step_ = false; }

 private:
  void drop(std::size_t count) noexcept;

  std::array<std::uint8_t, max_record_size> data_{};
  std::size_t size_ = 0;
  bool in_step_ = false;  // what came so far was all records
  Record record_;
};

/// A command of the initialisation; none past the last. Neither model answers them.
struct Command {
  std::array<char, 48> data{};
  std::size_t size = 0;

  std::span<const std::uint8_t> bytes() const noexcept {
    return {reinterpret_cast<const std::uint8_t*>(data.data()), size};
  }
};
/// Silence, inches, for stations 1 to num_stations position and quaternion, binary, and continuous records.
std::optional<Command> init_command(Model model, std::size_t index, std::size_t num_stations) noexcept;
/// Commands that set everything by which a tracker changes its poses; none past the last. Alignment,
/// boresight, tip offset and the frame of the source as they leave the factory, since the scene has frames of
/// its own; and the hemisphere.
/// hemisphere: direction from the source, in its frame, to the half of space in which the sensors are.
std::optional<Command> frame_command(Model model, std::size_t index, std::size_t num_stations,
                                     const Vec3& hemisphere) noexcept;

}  // namespace godobject::polhemus
