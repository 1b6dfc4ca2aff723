#include "platform/view/server/server.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <utility>

namespace godobject {
namespace {

constexpr std::size_t token_digits = 32;

bool is_address(std::string_view text) {
  std::array<std::uint8_t, 16> bytes{};
  const std::string name(text);
  return inet_pton(AF_INET, name.c_str(), bytes.data()) == 1 ||
         inet_pton(AF_INET6, name.c_str(), bytes.data()) == 1;
}

/// Compares in constant time for equal lengths.
bool same_secret(std::string_view a, std::string_view b) noexcept {
  if (a.size() != b.size()) return false;
  unsigned differs = 0;
  for (std::size_t i = 0; i < a.size(); ++i) differs |= static_cast<unsigned char>(a[i] ^ b[i]);
  return differs == 0;
}

/// Returns the value of `token` in "a=b&token=c".
std::string_view token_in(std::string_view query) {
  constexpr std::string_view key = "token=";
  while (!query.empty()) {
    const std::string_view pair = query.substr(0, query.find('&'));
    if (pair.starts_with(key)) return pair.substr(key.size());
    query.remove_prefix(std::min(query.size(), pair.size() + 1));
  }
  return {};
}

/// True if a list such as "a, b" contains the protocol.
bool offers(std::string_view protocols, std::string_view wanted) {
  while (!protocols.empty()) {
    std::string_view one = protocols.substr(0, protocols.find(','));
    protocols.remove_prefix(std::min(protocols.size(), one.size() + 1));
    while (one.starts_with(' ')) one.remove_prefix(1);
    while (one.ends_with(' ')) one.remove_suffix(1);
    if (one == wanted) return true;
  }
  return false;
}

Verdict refusal(int status, std::string reason) {
  return {.route = Route::refused, .status = status, .reason = std::move(reason)};
}

std::string new_token() {
  constexpr std::string_view digits = "0123456789abcdef";
  std::array<std::uint8_t, token_digits / 2> bytes{};
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) return "";
  std::string token;
  for (const std::uint8_t byte : bytes) (token += digits[byte >> 4u]) += digits[byte & 15u];
  return token;
}

bool is_token(std::string_view text) {
  return text.size() == token_digits && text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

/// Returns the token in a file that only its owner can read, created if missing; empty on failure.
std::string token_in_file(const std::string& path) {
  constexpr mode_t mine_alone = 0600;
  const int file = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, mine_alone);
  if (file < 0) return "";
  struct stat status {};
  std::string token;
  if (fstat(file, &status) == 0 && S_ISREG(status.st_mode) && status.st_uid == geteuid() &&
      (status.st_mode & 077u) == 0) {
    std::array<char, token_digits> text{};
    const ssize_t size = read(file, text.data(), text.size());
    token.assign(text.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
    if (!is_token(token)) {
      token = new_token();
      const bool kept = ftruncate(file, 0) == 0 &&
                        pwrite(file, token.data(), token.size(), 0) == static_cast<ssize_t>(token.size());
      if (!kept) token.clear();
    }
  }
  close(file);
  return token;
}

/// Returns the user's folder for session files; empty if there is none.
std::string run_time_folder() {
  const auto in_environment = [](const char* name) -> std::string {
    const char* const value = std::getenv(name);  // NOLINT(concurrency-mt-unsafe): the environment is never
                                                  // set
    return value != nullptr && *value == '/' ? value : "";
  };
  if (const std::string folder = in_environment("XDG_RUNTIME_DIR"); !folder.empty())
    return folder + "/godobject";
  const std::string home = in_environment("HOME");
  return home.empty() ? "" : home + "/.cache/godobject";
}

}  // namespace

bool is_loopback(std::string_view address) {
  return address == "::1" || (is_address(address) && address.starts_with("127."));
}

std::string view_token() {
  const std::string folder = run_time_folder();
  std::error_code error;
  if (!folder.empty()) {
    std::filesystem::create_directories(folder, error);
    if (std::string token = token_in_file(folder + "/view-token"); !token.empty()) return token;
  }
  return new_token();
}

Door::Door(std::string address, std::uint16_t port, std::string token)
    : address_(std::move(address)), token_(std::move(token)), port_(port), loopback_(is_loopback(address_)) {}

/// True for this server's own names. A foreign page may resolve its own name to this machine (DNS rebinding),
/// and then sends that name.
bool Door::is_own_host(std::string_view host) const {
  const std::size_t colon = host.rfind(':');
  if (colon == std::string_view::npos || host.substr(colon + 1) != std::to_string(port_)) return false;
  std::string_view name = host.substr(0, colon);
  if (name.starts_with('[') && name.ends_with(']')) name = name.substr(1, name.size() - 2);
  if (name == "localhost" || name == address_ || is_loopback(name)) return true;
  return !loopback_ && is_address(name);
}

Verdict Door::judge(const KnockHead& head) const {
  constexpr int bad_method = 405, forbidden = 403, upgrade_required = 426, switching = 101;
  if (!is_own_host(head.host))
    return refusal(forbidden,
                   "host '" + std::string(head.host.substr(0, 64)) + "' is no name of this server");
  if (head.method != "GET") return refusal(bad_method, "only GET is answered");
  const std::size_t question = head.target.find('?');
  const std::string path(head.target.substr(0, question));
  const std::string_view query = question == std::string_view::npos ? "" : head.target.substr(question + 1);
  const bool is_stream = path == "/stream",
             is_foxglove = is_stream && offers(head.protocols, foxglove_protocol);
  if (!is_stream && path != "/scene" && path != "/frames") return {.route = Route::file, .path = path};

  if (head.origin && !is_foxglove && *head.origin != "http://" + std::string(head.host))
    return refusal(forbidden, "a page of '" + std::string(head.origin->substr(0, 64)) +
                                  "' made the request, not this server's own");
  if (token_.empty() || !same_secret(token_in(query), token_))
    return refusal(forbidden, "the token is missing or wrong: use the address as it was printed");
  if (path == "/scene") return {.route = Route::scene};
  if (path == "/frames") return {.route = Route::frames};
  if (!head.upgrade) return refusal(upgrade_required, "/stream is a WebSocket");
  if (is_foxglove) return {.route = Route::foxglove, .status = switching};
  if (offers(head.protocols, stream_protocol)) return {.route = Route::stream, .status = switching};
  return refusal(upgrade_required, "the WebSocket's protocol is " + std::string(stream_protocol) + " or " +
                                       std::string(foxglove_protocol));
}

}  // namespace godobject
