// The poses for Foxglove and Lichtblick: the WebSocket protocol foxglove.websocket.v1 with messages in JSON. Two channels:
// /tf, foxglove.FrameTransforms, and /scene, foxglove.SceneUpdate.
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

/// A client's side of the conversation: what is said to it, and what it has subscribed to.
class FoxgloveClient {
 public:
  using Bytes = std::shared_ptr<const std::vector<std::uint8_t>>;

  FoxgloveClient();
  ~FoxgloveClient();
  FoxgloveClient(const FoxgloveClient&) = delete;
  FoxgloveClient& operator=(const FoxgloveClient&) = delete;

  /// What is said first: what this server can do, and its channels. scene: as a stream's first message (scene_json.h).
  std::vector<std::string> greeting(const std::string& scene);
  /// The answer to a message; mostly empty.
  std::string take(bool is_text, std::span<const std::uint8_t> message);
  /// A frame (frame.h), as messages of the channels that the client subscribes to. now_ns: of the day.
  /// send: false where the client has not taken what came before.
  void show(std::span<const std::uint8_t> frame, std::uint64_t now_ns,
            const std::function<bool(Bytes)>& send);

 private:
  struct Scene;
  void show_entities(std::span<const std::uint8_t> frame, std::uint64_t now_ns,
                     const std::function<bool(Bytes)>& send);

  std::unique_ptr<Scene> scene_;
  std::array<std::optional<std::uint32_t>, 2> subscriptions_;  // of each channel
  bool solids_due_ = false;                                    // they move with their frames: once is enough
  std::uint64_t nets_sent_ns_ = 0;                             // nets do not: again and again
};

}  // namespace godobject
