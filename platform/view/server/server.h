// Server of the view: HTTP and WebSockets on a thread of its own, for a source of frames. Not part of the
// loop.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
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
  /// Releases the bodies or joints of a client that is gone.
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

}  // namespace godobject
