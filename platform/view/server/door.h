// Access control: checks every request to the view's server before any action.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace godobject {

/// Relevant parts of a request's head.
struct KnockHead {
  std::string_view method, target, host;
  std::optional<std::string_view> origin{};  // absent: not a browser
  bool upgrade = false;                      // to a WebSocket
  std::string_view protocols{};              // offered by the client
};

enum class Route : std::uint8_t { refused, file, scene, frames, stream, foxglove };

struct Verdict {
  Route route = Route::refused;
  int status = 200;      // HTTP status; 101 if the connection becomes a WebSocket
  std::string path{};    // path of a file: "/app.js"
  std::string reason{};  // reason of a refusal, for the log and the client
};

/// The subprotocols of WebSockets.
inline constexpr std::string_view stream_protocol = "godobject.view.v1",
                                  foxglove_protocol = "foxglove.websocket.v1";

class Door {
 public:
  /// address: address of the listening socket. token: secret that every request for data needs.
  Door(std::string address, std::uint16_t port, std::string token);

  /// Returns the verdict on a request. Files are for every request with a name of this machine. Data needs
  /// the token and, from a browser, a page of this server. Foxglove's pages have other origins, so there the
  /// token alone is checked.
  Verdict judge(const KnockHead& head) const;

 private:
  bool is_own_host(std::string_view host) const;

  std::string address_, token_;
  std::uint16_t port_;
  bool loopback_;
};

/// Returns a secret token of 32 hexadecimal digits. It is kept in the file `view-token` in the user's
/// run-time folder, so that a page finds the next run. Without such a folder it is new each time.
std::string view_token();

bool is_loopback(std::string_view address);

}  // namespace godobject
