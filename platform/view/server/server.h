// The view's server: HTTP and WebSockets on one thread of its own, for what a source shows. Nothing of it is in the loop.
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

/// What is shown. The server's thread calls it, and no other.
class ViewSource {
 public:
  virtual ~ViewSource() = default;

  /// The scene as JSON (docs/view.md): the first message of every stream.
  virtual std::string scene() = 0;
  /// A recording's frames one after the other; null: it is live.
  virtual ViewBytes recording() { return nullptr; }
  /// The next frame; null: there is none yet. Called every few milliseconds while somebody looks.
  virtual ViewBytes frame() { return nullptr; }
  /// What a client's pointer says. False: pointers move nothing here, or somebody else's does.
  virtual bool point(std::uint64_t /*client*/, const PointerMessage& /*message*/) { return false; }
  /// Applies a page's shifts of joints. False: joints are not moved by pages here, or another page moves them.
  virtual bool move_joints(std::uint64_t /*client*/, const JointsMessage& /*message*/) { return false; }
  /// The client is gone.
  virtual void leave(std::uint64_t /*client*/) {}
};

class ViewServer {
 public:
  /// Takes a line about who was refused or has come. In the server's thread.
  using Log = std::function<void(const std::string&)>;

  /// Listens, with its thread. Null: why not, and what to do. The source outlives it.
  static std::unique_ptr<ViewServer> start(const ServerSettings& settings, ViewSource& source, Log log,
                                           std::string& why_not);
  virtual ~ViewServer() = default;

  /// The address of the page, with the token.
  virtual std::string url() const = 0;
};

}  // namespace godobject
