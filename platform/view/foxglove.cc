#include "platform/view/foxglove.h"

namespace godobject {
std::vector<std::string> FoxgloveClient::greeting(const std::string&) { return {}; }
std::string FoxgloveClient::take(bool, std::span<const std::uint8_t>) { return {}; }
void FoxgloveClient::show(std::span<const std::uint8_t>,
                          const std::function<void(std::shared_ptr<const std::vector<std::uint8_t>>)>&) {}
}  // namespace godobject
