// How a CAN interface is configured, asked of the kernel over rtnetlink, and what of it is in the way.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "platform/linux/bus/bus.h"

namespace godobject {

/// What only an interface with a controller has; a virtual one (vcan) has none of it.
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
  std::uint32_t mtu = 0;  // 16: classic, 72: FD too
  std::uint32_t transmit_queue_length = 0;
  std::array<char, 16> qdisc{};  // queueing discipline, e.g. pfifo_fast
  std::optional<CanController> controller{};

  bool carries_fd() const noexcept { return mtu >= 72; }
};

/// 0, or errno: ENODEV there is no such interface, EMEDIUMTYPE it is not a CAN one. Does not allocate.
int read_can_link(const char* interface, CanLink& link) noexcept;

enum class LinkFit : std::uint8_t { fits, down, bit_rate, data_bit_rate, classic_only };

/// The first thing that keeps `link` from carrying what `settings` expects.
LinkFit fit(const CanLink& link, const BusSettings& settings) noexcept;

/// What to do about a link that does not fit, with the commands. Empty when it fits.
std::string text_of(LinkFit fit, const std::string& interface, const CanLink& link,
                    const BusSettings& settings);

/// What will hurt later: no restart after bus-off, a queue that drops old frames. Empty when nothing.
std::string link_warnings(const std::string& interface, const CanLink& link);

}  // namespace godobject
