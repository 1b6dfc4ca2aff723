// Server of the view: HTTP and WebSockets on a thread of its own, for a source of frames. Includes access
// control, the embedded page, and poses for Foxglove and Lichtblick. Not part of the loop.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "platform/view/frame.h"

namespace godobject {

inline constexpr std::uint16_t default_view_port = 7780;

struct ServerSettings {
  std::string address = "127.0.0.1";
  std::uint16_t port = 0;  // 0: default_view_port, or one of the nine after it
  std::string token{};
};

using ViewBytes = std::shared_ptr<const std::vector<std::uint8_t>>;

/// Source of the scene and its frames. Called only by the server's thread.
class ViewSource {
 public:
  virtual ~ViewSource() = default;

  /// The scene as JSON (docs/view.md): the first message of every stream.
  virtual std::string scene() = 0;
  /// All frames of a recording, one after the other; null for a live source.
  virtual ViewBytes recording() { return nullptr; }
  /// The next frame; null if there is none yet. Called every few milliseconds while a client is connected.
  virtual ViewBytes frame() { return nullptr; }
  /// Applies a message of a client's pointer. Returns false if pointers move no bodies here, or another
  /// client's pointer does.
  virtual bool point(std::uint64_t /*client*/, const PointerMessage& /*message*/) { return false; }
  /// Applies a page's displacements of joints. Returns false if pages move no joints here, or another page
  /// moves them.
  virtual bool move_joints(std::uint64_t /*client*/, const JointsMessage& /*message*/) { return false; }
  /// Sets the speed of the run. Returns false if pages may not set it.
  virtual bool set_pace(std::uint64_t /*client*/, const PaceMessage& /*message*/) { return false; }
  /// Starts the run again. Returns why this is refused; empty if it is not.
  virtual std::string reset() { return "this is no run"; }
  /// Releases the bodies, joints or speed of a client that is gone.
  virtual void leave(std::uint64_t /*client*/) {}
};

class ViewServer {
 public:
  /// Receives a line about clients that were refused or closed. Called in the server's thread.
  using Log = std::function<void(const std::string&)>;

  /// Listens and starts the thread. Returns null with the reason and the remedy in why_not. The source must
  /// outlive the server.
  static std::unique_ptr<ViewServer> start(const ServerSettings& settings, ViewSource& source, Log log,
                                           std::string& why_not);
  virtual ~ViewServer() = default;

  /// The address of the page, with the token.
  virtual std::string url() const = 0;
};

// Access control: checks every request before any action.

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

// The page and all its files, embedded in the program.

struct PageFile {
  std::string_view text;  // empty: there is no such file
  std::string_view type;  // media type of its contents, for HTTP
};

/// Returns a file of the page. path: "/", "/app.js".
PageFile page_file(std::string_view path) noexcept;
/// True if the program was built with the page.
bool has_page() noexcept;

// Poses for Foxglove and Lichtblick: the WebSocket protocol foxglove.websocket.v1 with messages in JSON. Two
// channels: /tf, foxglove.FrameTransforms, and /scene, foxglove.SceneUpdate.

/// Returns the JSON Schema of foxglove.FrameTransforms.
std::string foxglove_transforms_schema();

/// State of the protocol for one client: its messages and subscriptions.
class FoxgloveClient {
 public:
  using Bytes = std::shared_ptr<const std::vector<std::uint8_t>>;

  FoxgloveClient();
  ~FoxgloveClient();
  FoxgloveClient(const FoxgloveClient&) = delete;
  FoxgloveClient& operator=(const FoxgloveClient&) = delete;

  /// Returns the first messages: the server's capabilities and its channels. scene: first message of a stream
  /// (drawing.h).
  std::vector<std::string> greeting(const std::string& scene);
  /// Handles a message of the client. Returns the answer, mostly empty.
  std::string take(bool is_text, std::span<const std::uint8_t> message);
  /// Sends a frame (frame.h) as messages of the subscribed channels. now_ns: time of day, ns. send: returns
  /// false while the client has not accepted the previous messages.
  void show(std::span<const std::uint8_t> frame, std::uint64_t now_ns,
            const std::function<bool(Bytes)>& send);

 private:
  struct Scene;
  void show_entities(std::span<const std::uint8_t> frame, std::uint64_t now_ns,
                     const std::function<bool(Bytes)>& send);

  std::unique_ptr<Scene> scene_;
  std::array<std::optional<std::uint32_t>, 2> subscriptions_;  // subscription of each channel
  bool solids_due_ = false;         // sent once, because they move with their frames
  std::uint64_t nets_sent_ns_ = 0;  // last update of nets, which are sent repeatedly
};

}  // namespace godobject
