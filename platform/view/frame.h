// The view's messages on the wire, little-endian and of fixed layout (docs/view.md): what a period looks like, and what a
// pointer says.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hal/base/codec.h"
#include "hal/joint/kinematic_tree.h"
#include "platform/view/tap.h"

namespace godobject {

inline constexpr std::uint32_t frame_magic = 0x46564F47;    // "GOVF"
inline constexpr std::uint32_t pointer_magic = 0x50564F47;  // "GOVP"
inline constexpr std::uint16_t view_version = 1;
inline constexpr std::size_t frame_header_bytes = 120, frame_body_bytes = 28, frame_driven_bytes = 76,
                             frame_contact_bytes = 44, frame_vertex_bytes = 12, pointer_bytes = 40;
/// More contacts are counted and not sent.
inline constexpr std::size_t max_frame_contacts = 4096;

/// Bits of a frame's flags.
enum : std::uint8_t {
  frame_engaged = 1,
  frame_on_hold = 2,
  frame_oscillates = 4,
  frame_missed_deadlines = 8
};

/// Appends nothing else: `out` is the frame. vertices: of all moving surfaces, in their order.
void encode(const ViewSample& sample, std::span<const std::size_t> driven, std::span<const Vec3> vertices,
            std::vector<std::uint8_t>& out);

/// Bits of a pointer's buttons.
enum : std::uint16_t { pointer_holds = 1, pointer_moves = 2 };

/// What the pointer of a page says, as a relative device.
struct PointerMessage {
  std::uint32_t number = 0;    // rises with each message of a connection
  bool holds = false;          // the device has hold of the body
  bool moves = false;          // the clutch is closed: the target moves with the pointer
  std::uint32_t target = 0;    // index of the driven body
  Vec3 dp_W = Vec3::Zero();    // shift since the message before, m
  Vec3 dphi_W = Vec3::Zero();  // turn since then, rad
};
/// A message that asks for more is no pointer's.
inline constexpr double max_pointer_shift = 1, max_pointer_turn = 3.2;

ParseResult decode(std::span<const std::uint8_t> bytes, PointerMessage& out) noexcept;
std::array<std::uint8_t, pointer_bytes> encode(const PointerMessage& message) noexcept;

inline constexpr std::uint16_t joints_version = 2;
inline constexpr std::size_t joints_bytes = 16 + 4 * max_joints;

/// Shifts of the device's joints by a page: the pointer's message of version 2.
struct JointsMessage {
  std::uint32_t number = 0;             // rises with each message of a connection
  bool holds = false;                   // the page moves the joints; others are refused meanwhile
  std::uint32_t num_joints = 0;         // of the scene's `coordinates`
  std::array<double, max_joints> dq{};  // since the message before, rad or m; 0 beyond num_joints
};
/// Largest shift of a joint in a message, rad or m.
inline constexpr double max_joint_shift = 1;

ParseResult decode(std::span<const std::uint8_t> bytes, JointsMessage& out) noexcept;
std::array<std::uint8_t, joints_bytes> encode(const JointsMessage& message) noexcept;

}  // namespace godobject
