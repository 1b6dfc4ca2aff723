// OpenIGTLink, versions 1 to 3 (openigtlink.org): messages on a TCP connection, as PLUS and 3D Slicer send
// them. Numbers are big-endian, lengths in mm:
//   header    version (u16), type (12 characters), device (20), time (u64, s 2^-32), bytes of the body (u64),
//             CRC-64 of the body
//   body      from version 2 on after an extended header and before meta data, which are passed over
//
// The receiver reads TRANSFORM, the pose of the device, and TDATA, those of several tools. It passes over
// other messages.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/math/types.h"
#include "hal/base/nanoseconds.h"

namespace godobject::openigtlink {

inline constexpr std::size_t header_bytes = 58, transform_bytes = 48, tool_bytes = 70, max_name = 20;

/// Computes the CRC-64 of ECMA-182, MSB first. before: CRC of the bytes before. Check value of "123456789":
/// 6C40DF5F0B497347.
std::uint64_t crc64(std::span<const std::uint8_t> bytes, std::uint64_t before = 0) noexcept;

struct Header {
  std::uint16_t version = 1;
  std::array<char, 13> type{};              // ends with a zero
  std::array<char, max_name + 1> device{};  // ends with a zero
  Nanoseconds t = 0;                        // by the clock of the sender; 0: none
  std::uint64_t body_size = 0, crc = 0;
};

/// Pose of a tool in a message.
struct ToolPose {
  std::string_view name;
  std::optional<Pose> X_TH;  // absent: not finite, no rotation, or farther than max_distance
};
inline constexpr double max_distance = 10;  // m

/// Splits a stream into messages. Owns its memory; no call allocates.
class Receiver {
 public:
  enum class Event : std::uint8_t {
    more,       // all bytes were taken, and a message is incomplete
    message,    // a TRANSFORM or TDATA, see num_poses()
    passed,     // another message: see header()
    bad_crc,    // the message is dropped
    malformed,  // a TRANSFORM or TDATA of another size is dropped
    no_header,  // the bytes are no header, or that of an absurd size: the stream cannot be read on
  };

  /// Takes bytes from the front of `bytes` up to the end of a message.
  Event push(std::span<const std::uint8_t>& bytes) noexcept;
  void reset() noexcept { size_ = 0; }
  /// True if a message is incomplete.
  bool is_amid() const noexcept { return size_ != 0; }

  const Header& header() const noexcept { return header_; }
  /// Number of poses of the last message, until the next push().
  std::size_t num_poses() const noexcept;
  ToolPose pose(std::size_t index) const noexcept;

 private:
  bool read_header() noexcept;
  bool is_tdata() const noexcept;
  bool is_pose_message() const noexcept;
  Event finish() noexcept;

  static constexpr std::size_t capacity = 8192;  // of a body that is read
  std::array<std::uint8_t, header_bytes + capacity> bytes_{};
  std::uint64_t size_ = 0;  // bytes of the message so far, also those that are passed over
  Header header_;
  std::span<const std::uint8_t> content_{};
};

/// A message of version 1 to send. Owns its memory; bytes beyond its capacity are left out.
class Message {
 public:
  /// device: at most 20 characters are sent. t: time since 1970, ns; 0: none.
  Message(std::string_view type, std::string_view device, Nanoseconds t) noexcept;

  Message& number(std::uint64_t value, std::size_t size) noexcept;
  Message& real(double value) noexcept;
  /// Appends characters, with zeros up to `size`.
  Message& text(std::string_view text, std::size_t size) noexcept;
  /// Appends a pose as TRANSFORM and TDATA have it.
  Message& pose(const Pose& X) noexcept;
  /// Completes the header, and returns all bytes, which are valid as long as this object.
  std::span<const std::uint8_t> finish() noexcept;

 private:
  std::array<std::uint8_t, 4096> bytes_{};
  std::size_t size_ = 0;
};

}  // namespace godobject::openigtlink
