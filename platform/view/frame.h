// Binary messages of the view, little-endian with a fixed layout (docs/view.md): frames of a period, and
// messages of a page's pointer.
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
/// Further contacts are counted and not sent.
inline constexpr std::size_t max_frame_contacts = 4096;

/// Bits of a frame's flags.
enum : std::uint8_t {
  frame_engaged = 1,
  frame_on_hold = 2,
  frame_oscillates = 4,
  frame_missed_deadlines = 8
};

/// Encodes a frame into `out`, which it replaces. driven: indices of driven bodies. vertices: positions of
/// all moving surfaces' vertices, in their order, world, m.
void encode(const ViewSample& sample, std::span<const std::size_t> driven, std::span<const Vec3> vertices,
            std::vector<std::uint8_t>& out);

/// Bits of a pointer's buttons.
enum : std::uint16_t { pointer_holds = 1, pointer_moves = 2 };

/// Message of a page's pointer, as a relative device.
struct PointerMessage {
  std::uint32_t number = 0;    // increases with each message of a connection
  bool holds = false;          // true while the pointer grips the body
  bool moves = false;          // true if the clutch is closed: the target moves with the pointer
  std::uint32_t target = 0;    // index of the driven body
  Vec3 dp_W = Vec3::Zero();    // displacement since the previous message, m
  Vec3 dphi_W = Vec3::Zero();  // rotation since then, rad
};
/// Limits on dp_W, m, and dphi_W, rad; messages beyond them are invalid.
inline constexpr double max_pointer_shift = 1, max_pointer_turn = 3.2;

ParseResult decode(std::span<const std::uint8_t> bytes, PointerMessage& out) noexcept;
std::array<std::uint8_t, pointer_bytes> encode(const PointerMessage& message) noexcept;

inline constexpr std::uint16_t joints_version = 2;
inline constexpr std::size_t joints_bytes = 16 + 4 * max_joints;

/// Displacements of the device's joints by a page: the pointer's message of version 2.
struct JointsMessage {
  std::uint32_t number = 0;      // increases with each message of a connection
  bool holds = false;            // true while the page moves the joints; other pages are refused meanwhile
  std::uint32_t num_joints = 0;  // number of the scene's `coordinates`
  // displacements since the previous message, rad or m; 0 beyond num_joints
  std::array<double, max_joints> dq{};
};
/// Largest displacement of a joint in a message, rad or m.
inline constexpr double max_joint_shift = 1;

ParseResult decode(std::span<const std::uint8_t> bytes, JointsMessage& out) noexcept;
std::array<std::uint8_t, joints_bytes> encode(const JointsMessage& message) noexcept;

}  // namespace godobject
