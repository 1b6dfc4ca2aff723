#include "hal/tracker/unread_bytes.h"

#include <algorithm>
#include <cstdio>
#include <string_view>

#include "hal/tracker/polhemus.h"

namespace godobject {
namespace {

bool is_text(std::uint8_t c) noexcept {
  return (c >= ' ' && c <= '~') || c == '\r' || c == '\n' || c == '\t';
}

bool is_ndi(std::string_view text) noexcept {
  return text.find("RESET") != text.npos || text.find("ERROR") == 0 || text.find("OKAY") == 0 ||
         text.find("\rERROR") != text.npos || text.find("\rOKAY") != text.npos;
}

/// True if the bytes contain a whole Polhemus record.
bool has_record(std::span<const std::uint8_t> bytes) noexcept {
  polhemus::RecordReceiver receiver;
  return std::ranges::any_of(bytes, [&](std::uint8_t byte) {
    return receiver.push(byte) == polhemus::RecordReceiver::Event::record;
  });
}

}  // namespace

void UnreadBytes::add(std::span<const std::uint8_t> bytes) noexcept {
  for (const std::uint8_t byte : bytes) {
    if (count_ < first_.size()) first_[static_cast<std::size_t>(count_)] = byte;
    ++count_;
  }
}

void UnreadBytes::describe(TrackerProtocol expected, std::uint32_t baud, std::span<char> out) const noexcept {
  const auto size = static_cast<std::size_t>(std::min<std::uint64_t>(count_, first_.size()));
  const std::span<const std::uint8_t> known(first_.data(), size);
  const std::string_view text(reinterpret_cast<const char*>(known.data()), size);
  const bool polhemus = expected == TrackerProtocol::polhemus;
  const bool all_text = std::ranges::all_of(known, is_text);
  std::array<char, 20> begin{};
  for (std::size_t i = 0; i < std::min<std::size_t>(size, all_text ? 16 : 5); ++i) {
    if (all_text) begin[i] = known[i] < ' ' ? ' ' : static_cast<char>(known[i]);
    else std::snprintf(&begin[3 * i], 4, "%02X ", unsigned{known[i]});
  }
  char remedy[80] = "";
  if (polhemus && is_ndi(text)) {
    std::snprintf(remedy, sizeof remedy, "the answer is that of an NDI tracker: set protocol = \"ndi\"");
  } else if (!polhemus && has_record(known)) {
    std::snprintf(remedy, sizeof remedy, "the records are those of a Polhemus: set protocol = \"polhemus\"");
  } else if (all_text) {
    std::snprintf(remedy, sizeof remedy, "text, %s",
                  polhemus ? "not binary records: wrong protocol, or fixed ASCII mode"
                           : "without NDI's CRC: wrong protocol");
  } else {
    std::snprintf(remedy, sizeof remedy, "wrong protocol, or baud (%u), or noise", unsigned{baud});
  }
  std::snprintf(out.data(), out.size(), "%llu bytes not recognised ('%s'): %s",
                static_cast<unsigned long long>(count_), begin.data(), remedy);
}

}  // namespace godobject
