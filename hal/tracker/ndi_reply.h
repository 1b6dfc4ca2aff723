// What the replies of the NDI Combined API hold: poses (TX, BX), port handles (PHSR), a tool's plate (PHINF). All
// parse functions take what ReplyReceiver::content() gives, any bytes, and write their output on `ok` only.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/math/types.h"
#include "hal/base/codec.h"

namespace godobject::ndi {

/// Reply options of TX and BX: what a reply holds is told by the command alone.
namespace option {
inline constexpr std::uint16_t transforms = 0x0001;
inline constexpr std::uint16_t tool_and_markers = 0x0002;
inline constexpr std::uint16_t stray_active_marker = 0x0004;
inline constexpr std::uint16_t markers_on_tools = 0x0008;
inline constexpr std::uint16_t also_out_of_volume = 0x0800;
inline constexpr std::uint16_t stray_passive_markers = 0x1000;
}  // namespace option

/// The status of a handle, as BX has it on the wire.
enum class HandleStatus : std::uint8_t {
  implausible = 0x00,  // never on the wire: valid by its status, but its pose is none
  valid = 0x01,
  missing = 0x02,   // not seen: hidden, or out of sight
  disabled = 0x04,  // disabled, or nothing in the port
};

/// Bits of a handle's port status.
namespace port_status {
inline constexpr std::uint32_t tool_in_port = 0x01;
inline constexpr std::uint32_t initialised = 0x10;
inline constexpr std::uint32_t enabled = 0x20;
inline constexpr std::uint32_t out_of_volume = 0x40;
inline constexpr std::uint32_t partly_out_of_volume = 0x80;
}  // namespace port_status

/// One handle of a TX or BX reply.
struct HandlePose {
  std::uint8_t handle = 0;
  HandleStatus status = HandleStatus::disabled;
  Pose X_TH;                    // the tool in the tracker's frame; when valid
  double error_m = 0;           // RMS of the markers against the tool's geometry
  std::uint32_t port_bits = 0;  // see port_status; not of a disabled handle
  std::uint32_t frame = 0;      // counts up with the tracker's measurements
};

inline constexpr std::size_t max_handles = 0xFE;

/// A TX or BX reply.
struct PoseReply {
  std::array<HandlePose, max_handles> handles;
  std::size_t num_handles = 0;
  std::uint16_t system_status = 0;  // see system_status_text

  std::span<const HandlePose> all() const noexcept { return {handles.data(), num_handles}; }
};

/// Handling of a handle whose pose is none: NaN, no turn, or too far away.
enum class ImplausiblePose : std::uint8_t {
  refuse_reply,  // `bad_value`
  mark_handle,   // HandleStatus::implausible; the other handles stand
};

/// Text, after a TX command with these options.
[[nodiscard]] ParseResult parse_tx(std::span<const std::uint8_t> text, std::uint16_t options, PoseReply& out,
                                   ImplausiblePose implausible = ImplausiblePose::refuse_reply) noexcept;
/// Body, after a BX command with these options.
[[nodiscard]] ParseResult parse_bx(std::span<const std::uint8_t> body, std::uint16_t options, PoseReply& out,
                                   ImplausiblePose implausible = ImplausiblePose::refuse_reply) noexcept;

/// The gravest of the bits of the system status that ask for something to be done; null without any.
const char* system_status_text(std::uint16_t status) noexcept;

struct PortHandle {
  std::uint8_t handle = 0;
  std::uint16_t status = 0;  // the low twelve bits of its port status
};

struct PortHandles {
  std::array<PortHandle, max_handles> handles{};
  std::size_t size = 0;

  std::span<const PortHandle> all() const noexcept { return {handles.data(), size}; }
};

/// Reply to PHSR. `too_long`: more than max_handles of them.
[[nodiscard]] ParseResult parse_phsr(std::span<const std::uint8_t> text, PortHandles& out) noexcept;

/// What is written on a tool: reply to PHINF with option 0001.
struct ToolPlate {
  std::array<char, 13> manufacturer{};  // ends with a zero
  std::array<char, 9> serial{};         // likewise
  std::uint8_t port_bits = 0;
};
[[nodiscard]] ParseResult parse_phinf(std::span<const std::uint8_t> text, ToolPlate& out) noexcept;

}  // namespace godobject::ndi
