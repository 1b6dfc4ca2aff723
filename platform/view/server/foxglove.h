// Poses for Foxglove and Lichtblick: the WebSocket protocol foxglove.websocket.v1 with messages in JSON. Two
// channels: /tf, foxglove.FrameTransforms, and /scene, foxglove.SceneUpdate.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace godobject {

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
