// Who may see what: every request to the view's server is judged here, before anything is done for it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace godobject {

/// What the head of a request says, as far as it matters.
struct KnockHead {
  std::string_view method, target, host;
  std::optional<std::string_view> origin{};  // absent: not a browser
  bool upgrade = false;                      // to a WebSocket
  std::string_view protocols{};              // that it offers
};

enum class Route : std::uint8_t { refused, file, scene, frames, stream, foxglove };

struct Verdict {
  Route route = Route::refused;
  int status = 200;      // of HTTP; 101 where the connection becomes a WebSocket
  std::string path{};    // of a file: "/app.js"
  std::string reason{};  // of a refusal, for the log and for who asked
};

/// The subprotocols of WebSockets.
inline constexpr std::string_view stream_protocol = "godobject.view.v1",
                                  foxglove_protocol = "foxglove.websocket.v1";

class Door {
 public:
  /// address: that is listened on; token: that every request for data needs.
  Door(std::string address, std::uint16_t port, std::string token);

  /// Files are for everyone who comes by a name of this machine's own; data needs the token, and, in a browser, a page of
  /// this server. Foxglove's pages are others, so there the token alone counts.
  Verdict judge(const KnockHead& head) const;

 private:
  bool knows_host(std::string_view host) const;

  std::string address_, token_;
  std::uint16_t port_;
  bool loopback_;
};

/// 32 hexadecimal digits that nobody can guess. From the file `view-token` in the user's run-time folder, made where it is
/// not there, so that a page finds the next run; where there is no such folder, new each time.
std::string view_token();

bool is_loopback(std::string_view address);

}  // namespace godobject
