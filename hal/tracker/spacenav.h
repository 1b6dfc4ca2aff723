// Messages of spacenavd, the daemon of 6-DoF mice (3Dconnexion's SpaceMouse and others), on its unix socket,
// to a client that sends nothing (protocol 0). A message is eight 32-bit integers in native byte order. The
// first is the kind. x y z rx ry rz and the ms since the last motion follow, or the number of a button.
// Derived from <spnav.h> and events of spacenavd 1.1.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <span>

#include "core/math/types.h"
#include "hal/base/codec.h"

namespace godobject {

struct SpacenavEvent {
  enum class Kind : std::uint8_t { motion, press, release };
  Kind kind = Kind::motion;
  // Axes of a motion: translation, rotation; counts of the device times the daemon's sensitivity.
  std::array<std::int32_t, 6> axes{};
  std::int32_t button = 0;  // button number, from 0
};

inline constexpr std::size_t spacenav_event_bytes = 32;
/// Plausibility limits. A SpaceMouse sends 350 at its stops, times the daemon's sensitivity; far larger
/// values are no motion.
inline constexpr std::int32_t max_spacenav_counts = 100'000, max_spacenav_button = 255;

/// Parses a message. Returns other_message for an event of later protocols, which this client does not
/// request, bad_value for an invalid stream.
[[nodiscard]] inline ParseResult decode(std::span<const std::uint8_t> bytes, SpacenavEvent& out) noexcept {
  if (const ParseResult size = check_size(bytes.size(), spacenav_event_bytes); size != ParseResult::ok)
    return size;
  std::array<std::int32_t, 8> words{};
  std::memcpy(words.data(), bytes.data(), spacenav_event_bytes);
  constexpr std::int32_t first_unknown = 7;
  if (words[0] < 0 || words[0] >= first_unknown) return ParseResult::bad_value;
  if (words[0] > static_cast<std::int32_t>(SpacenavEvent::Kind::release)) return ParseResult::other_message;
  SpacenavEvent event{.kind = static_cast<SpacenavEvent::Kind>(words[0])};
  if (event.kind != SpacenavEvent::Kind::motion) {
    event.button = words[1];
    if (event.button < 0 || event.button > max_spacenav_button) return ParseResult::bad_value;
  }
  for (std::size_t i = 0; event.kind == SpacenavEvent::Kind::motion && i < event.axes.size(); ++i) {
    event.axes[i] = words[i + 1];
    if (event.axes[i] < -max_spacenav_counts || event.axes[i] > max_spacenav_counts)
      return ParseResult::bad_value;
  }
  out = event;
  return ParseResult::ok;
}

/// Converts axes. The daemon's are x right, y up, z away from the user (left-handed); here x right, y away, z
/// up. The same mapping holds for vectors and rotation vectors, because the daemon inverts the signs of both.
inline Vec3 spacenav_vector(const SpacenavEvent& event, std::size_t first) noexcept {
  return {static_cast<double>(event.axes[first]), static_cast<double>(event.axes[first + 2]),
          static_cast<double>(event.axes[first + 1])};
}

}  // namespace godobject
