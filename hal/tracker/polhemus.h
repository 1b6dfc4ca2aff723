// Binary records of Polhemus trackers: Fastrak (32 bytes), Liberty and Patriot (41, or 45 with a button).
// There is no CRC: a record is recognised by its first and last bytes and a quaternion of unit length.
// Changes of a few low bits of a position are not detected here; PolhemusTracker bounds them by the speed of
// a hand.
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
  char error = ' ';          // ' ': none; otherwise a letter of the manual's table
  Pose X_TH{};               // sensor pose in the frame of its source; inches on the wire
  std::uint32_t t_ms = 0;    // Liberty: its clock
};

inline constexpr std::size_t fastrak_size = 32;
inline constexpr std::size_t liberty_header = 8;
inline constexpr std::size_t liberty_payload = 33;         // position, quaternion, time, space
inline constexpr std::size_t liberty_button_payload = 37;  // with the button's 32 bits before the space
inline constexpr std::size_t max_record_size = liberty_header + liberty_button_payload;
inline constexpr std::size_t max_fastrak_stations = 4;
inline constexpr std::size_t max_stations = 16;

/// Encodes a record for the wire, for Liberty without a button. Returns an empty span if `out` is too small.
[[nodiscard]] std::span<const std::uint8_t> make_record(const Record& record,
                                                        std::span<std::uint8_t> out) noexcept;

/// Parses from the first byte of a record. Returns `too_short` if more bytes are needed. size: set on `ok`
/// and on `bad_value`, where 0 means that no record ends at the expected place.
[[nodiscard]] ParseResult parse_record(std::span<const std::uint8_t> bytes, Record& out,
                                       std::size_t& size) noexcept;

/// Extracts records from the stream; resynchronises at the next record after a broken one.
class RecordReceiver {
 public:
  enum class Event : std::uint8_t {
    more,
    record,     // record() is new
    malformed,  // a record without a pose, or bytes out of step (reported once until the next record)
  };
  Event push(std::uint8_t byte) noexcept;
  const Record& record() const noexcept { return record_; }
  void reset() noexcept { size_ = 0, in_step_ = false; }

 private:
  void drop(std::size_t count) noexcept;

  std::array<std::uint8_t, max_record_size> data_{};
  std::size_t size_ = 0;
  bool in_step_ = false;  // all bytes so far formed records
  Record record_;
};

/// A command of the initialisation. The trackers do not answer it.
struct Command {
  std::array<char, 48> data{};
  std::size_t size = 0;

  std::span<const std::uint8_t> bytes() const noexcept {
    return {reinterpret_cast<const std::uint8_t*>(data.data()), size};
  }
};
/// Returns command `index`: stop, inches, position and quaternion for stations 1 to num_stations, binary,
/// continuous. Returns nullopt after the last.
std::optional<Command> init_command(Model model, std::size_t index, std::size_t num_stations) noexcept;
/// Returns command `index` of those that reset the tracker's own pose transformations; nullopt after the
/// last. Alignment, boresight, tip offset and source frame are reset to factory values, because the scene has
/// its own frames. The last command sets the hemisphere.
/// hemisphere: direction from the source, in its frame, to the half space of the sensors.
std::optional<Command> frame_command(Model model, std::size_t index, std::size_t num_stations,
                                     const Vec3& hemisphere) noexcept;

}  // namespace godobject::polhemus
