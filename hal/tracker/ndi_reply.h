// Parses replies of the NDI Combined API: poses (TX, BX, BX2), port handles (PHSR), tool information
// (PHINF). All parse functions accept any bytes from ReplyReceiver::content() and write their output on `ok`
// only.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/math/types.h"
#include "hal/base/codec.h"
#include "hal/base/nanoseconds.h"

namespace godobject::ndi {

/// Reply options of TX and BX. Replies do not contain them: only the command determines the format.
namespace option {
inline constexpr std::uint16_t transforms = 0x0001;
inline constexpr std::uint16_t tool_and_markers = 0x0002;
inline constexpr std::uint16_t stray_active_marker = 0x0004;
inline constexpr std::uint16_t markers_on_tools = 0x0008;
inline constexpr std::uint16_t also_out_of_volume = 0x0800;
inline constexpr std::uint16_t stray_passive_markers = 0x1000;
}  // namespace option

/// Status of a handle, encoded as in BX.
enum class HandleStatus : std::uint8_t {
  implausible = 0x00,  // never sent: the status was valid, but the pose is not plausible
  valid = 0x01,
  missing = 0x02,   // hidden or out of sight
  disabled = 0x04,  // disabled, or the port is empty
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
  Pose X_TH;                    // pose of the tool in the tracker's frame, if valid
  double error_m = 0;           // RMS deviation of the markers from the tool's geometry
  std::uint32_t port_bits = 0;  // see port_status; not set for a disabled handle
  std::uint32_t frame = 0;      // measurement counter of the tracker
};

inline constexpr std::size_t max_handles = 0xFE;

/// A TX, BX or BX2 reply.
struct PoseReply {
  std::array<HandlePose, max_handles> handles;
  std::size_t num_handles = 0;
  Nanoseconds t_ns = 0;             // time of the measurement by the tracker's clock; 0: none (TX, BX)
  std::uint16_t system_status = 0;  // see system_status_text

  std::span<const HandlePose> all() const noexcept { return {handles.data(), num_handles}; }
};

/// Treatment of a handle with an implausible pose: NaN, no rotation, or too far away.
enum class ImplausiblePose : std::uint8_t {
  refuse_reply,  // `bad_value`
  mark_handle,   // HandleStatus::implausible; the other handles are used
};

/// Parses the text of a reply to TX. options: those of the command.
[[nodiscard]] ParseResult parse_tx(std::span<const std::uint8_t> text, std::uint16_t options, PoseReply& out,
                                   ImplausiblePose implausible = ImplausiblePose::refuse_reply) noexcept;
/// Parses the body of a reply to BX. options: those of the command.
[[nodiscard]] ParseResult parse_bx(std::span<const std::uint8_t> body, std::uint16_t options, PoseReply& out,
                                   ImplausiblePose implausible = ImplausiblePose::refuse_reply) noexcept;

/// Parses the body of a reply to BX2 with poses of tools; other components are skipped.
[[nodiscard]] ParseResult parse_bx2(std::span<const std::uint8_t> body, PoseReply& out,
                                    ImplausiblePose implausible = ImplausiblePose::refuse_reply) noexcept;

/// Returns the text of the most severe system status bit that requires action; null if none is set.
const char* system_status_text(std::uint16_t status) noexcept;

struct PortHandle {
  std::uint8_t handle = 0;
  std::uint16_t status = 0;  // low twelve bits of its port status
};

struct PortHandles {
  std::array<PortHandle, max_handles> handles{};
  std::size_t size = 0;

  std::span<const PortHandle> all() const noexcept { return {handles.data(), size}; }
};

/// Parses a reply to PHSR. Returns `too_long` for more than max_handles handles.
[[nodiscard]] ParseResult parse_phsr(std::span<const std::uint8_t> text, PortHandles& out) noexcept;

/// Identification of a tool: reply to PHINF with option 0001.
struct ToolPlate {
  std::array<char, 13> manufacturer{};  // ends with a zero
  std::array<char, 9> serial{};         // ends with a zero
  std::uint8_t port_bits = 0;
};
[[nodiscard]] ParseResult parse_phinf(std::span<const std::uint8_t> text, ToolPlate& out) noexcept;

}  // namespace godobject::ndi
