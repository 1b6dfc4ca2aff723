#include "sim/tracker/polhemus.h"

#include <algorithm>
#include <cstdlib>
#include <string_view>

namespace godobject {

SimPolhemus::SimPolhemus(const TrackerParams& params, double rate_hz, std::uint64_t seed,
                         polhemus::Model model)
    : SimTracker(rate_hz, seed), model_(model), num_tools_(std::min(params.tools.size(), max_tracked_tools)) {
  for (std::size_t i = 0; i < num_tools_; ++i)
    stations_[i] = static_cast<std::uint8_t>(
        std::clamp(std::strtol(params.tools[i].tool.c_str(), nullptr, 10), 1L, 16L));
}

/// Fastrak's commands are single characters, except those that take numbers; Liberty's end with CR.
void SimPolhemus::receive(std::span<const std::uint8_t> bytes, Nanoseconds) noexcept {
  for (const std::uint8_t byte : bytes) {
    if (line_size_ == line_.size()) line_size_ = 0;
    line_[line_size_++] = byte;
    const bool fastrak = model_ == polhemus::Model::fastrak;
    const bool takes_numbers = fastrak ? line_[0] == 'O' : line_[0] != 'P';
    if (takes_numbers && byte != '\r') continue;
    obey({line_.data(), line_size_});
    line_size_ = 0;
  }
}

void SimPolhemus::obey(std::span<const std::uint8_t> command) noexcept {
  const std::string_view text(reinterpret_cast<const char*>(command.data()), command.size());
  const bool fastrak = model_ == polhemus::Model::fastrak;
  if (text == (fastrak ? "c" : "P")) continuous_ = false;
  if (text == (fastrak ? "f" : "F1\r")) binary_ = true;
  if (text == (fastrak ? "F" : "F0\r")) binary_ = false;
  if (text == (fastrak ? "C" : "C\r")) continuous_ = true;
  if (text.size() < 3 || text[0] != 'O') return;
  const std::size_t comma = text.find(',');
  std::size_t station = 0;
  for (std::size_t i = 1; i < comma && i < 4 && i < text.size(); ++i)
    station = 10 * station + static_cast<std::size_t>(text[i] - '0');
  if (comma == std::string_view::npos || station >= has_format_.size()) return;
  has_format_[station] = text.substr(comma) == (fastrak ? ",2,11,0\r" : ",2,7,8,0\r");
}

void SimPolhemus::measured(Nanoseconds now) noexcept {
  if (!binary_ || !continuous_) return;
  for (std::size_t i = 0; i < num_tools_; ++i) {
    if (!has_format_[stations_[i]] || faults.missing[i] || faults.disabled[i]) continue;
    std::array<std::uint8_t, polhemus::max_record_size> bytes{};
    const polhemus::Record record{.model = model_,
                                  .station = stations_[i],
                                  .X_TH = measurement().poses[i],
                                  .t_ms = static_cast<std::uint32_t>(measurement().t / 1'000'000)};
    send(polhemus::make_record(record, bytes), now);
  }
}

}  // namespace godobject
