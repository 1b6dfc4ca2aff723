// Address of a tracker on a network.
#pragma once

#include <algorithm>
#include <charconv>
#include <optional>
#include <string>
#include <string_view>

#include "hal/tracker/params.h"

namespace godobject {

struct TcpAddress {
  std::string host, port;
};

/// Returns the port of a protocol's servers; empty for a protocol without them.
inline std::string_view default_tcp_port(TrackerProtocol protocol) noexcept {
  switch (protocol) {
    case TrackerProtocol::ndi: return "8765";
    case TrackerProtocol::polhemus: return "";
    case TrackerProtocol::openigtlink: return "18944";
  }
  return "";
}

/// True if a tracker's port is an address instead of a serial line.
inline bool is_on_network(const TrackerParams& params) noexcept { return params.port.starts_with("tcp:"); }

/// Parses "tcp:HOST:PORT" or "tcp:[HOST]:PORT"; ":PORT" may be left out. None for other texts.
inline std::optional<TcpAddress> parse_tcp_address(std::string_view text, std::string_view default_port) {
  constexpr std::string_view scheme = "tcp:";
  if (!text.starts_with(scheme)) return std::nullopt;
  text.remove_prefix(scheme.size());
  TcpAddress address{.host = "", .port = std::string(default_port)};
  const bool has_brackets = text.starts_with('[');
  const std::size_t end = has_brackets ? text.find(']') : std::min(text.rfind(':'), text.size());
  if (end == std::string_view::npos) return std::nullopt;
  address.host = text.substr(has_brackets ? 1 : 0, end - (has_brackets ? 1 : 0));
  std::string_view rest = text.substr(end + (has_brackets ? 1 : 0));
  if (!rest.empty()) {
    if (!rest.starts_with(':')) return std::nullopt;
    rest.remove_prefix(1);
    unsigned port = 0;
    const auto [stop, error] = std::from_chars(rest.data(), rest.data() + rest.size(), port);
    if (error != std::errc() || stop != rest.data() + rest.size() || port < 1 || port > 65535)
      return std::nullopt;
    address.port = rest;
  }
  if (address.host.empty()) return std::nullopt;
  return address;
}

}  // namespace godobject
