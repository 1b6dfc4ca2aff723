// Configuration of a CAN interface, read from the kernel over rtnetlink, and its conflicts with the scene.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "platform/linux/bus/bus.h"

namespace godobject {

/// Properties of an interface with a controller; a virtual one (vcan) has none.
struct CanController {
  std::uint32_t bit_rate = 0;       // bit/s; 0: not set
  std::uint32_t data_bit_rate = 0;  // bit/s; 0: classic
  std::uint32_t restart_ms = 0;     // 0: stays off after a bus-off
  BusState state = BusState::closed;
  std::uint16_t transmit_error_counter = 0;
  std::uint16_t receive_error_counter = 0;
};

struct CanLink {
  bool up = false;
  std::uint32_t mtu = 0;  // 16: classic frames, 72: also FD
  std::uint32_t transmit_queue_length = 0;
  std::array<char, 16> qdisc{};  // queueing discipline, e.g. pfifo_fast
  std::optional<CanController> controller{};

  bool carries_fd() const noexcept { return mtu >= 72; }
};

/// Reads the configuration. Returns 0 or errno: ENODEV if the interface does not exist, EMEDIUMTYPE if it is
/// not a CAN interface. Does not allocate.
int read_can_link(const char* interface, CanLink& link) noexcept;

enum class LinkFit : std::uint8_t { fits, down, bit_rate, data_bit_rate, classic_only };

/// Returns the first conflict of `link` with the expected `settings`.
LinkFit fit(const CanLink& link, const BusSettings& settings) noexcept;

/// Returns the conflict and the commands that resolve it. Empty for LinkFit::fits.
std::string text_of(LinkFit fit, const std::string& interface, const CanLink& link,
                    const BusSettings& settings);

/// Returns warnings of later trouble: no restart after bus-off, a queue that drops old frames. Empty if none.
std::string link_warnings(const std::string& interface, const CanLink& link);

}  // namespace godobject
