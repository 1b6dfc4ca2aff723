// The poses for Foxglove and Lichtblick: the WebSocket protocol foxglove.websocket.v1 with messages in JSON.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace godobject {

class FoxgloveClient {
 public:
  /// What is said first: what this server can do, and its channels. scene: as a stream's first message.
  std::vector<std::string> greeting(const std::string& scene);
  /// The answer to a message; mostly empty.
  std::string take(bool is_text, std::span<const std::uint8_t> message);
  /// A frame, as messages of the channels that the client subscribes to.
  void show(std::span<const std::uint8_t> frame,
            const std::function<void(std::shared_ptr<const std::vector<std::uint8_t>>)>& send);
};

}  // namespace godobject
