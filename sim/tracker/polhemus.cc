#include "sim/tracker/polhemus.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string_view>

namespace godobject {

SimPolhemus::SimPolhemus(const TrackerParams& params, double rate_hz, std::uint64_t seed,
                         polhemus::Model model)
    : SimTracker(rate_hz, seed), model_(model), num_tools_(std::min(params.tools.size(), max_tracked_tools)) {
  hemispheres_.fill(Vec3::UnitX());
  for (std::size_t i = 0; i < num_tools_; ++i)
    stations_[i] = static_cast<std::uint8_t>(
        std::clamp(std::strtol(params.tools[i].tool.c_str(), nullptr, 10), 1L, 16L));
}

/// Receives commands. Fastrak's are single characters, except those with numbers; Liberty's end with CR.
void SimPolhemus::receive(std::span<const std::uint8_t> bytes, Nanoseconds now) noexcept {
  for (const std::uint8_t byte : bytes) {
    if (line_size_ == line_.size()) line_size_ = 0;
    line_[line_size_++] = byte;
    const bool fastrak = model_ == polhemus::Model::fastrak;
    const bool takes_numbers = fastrak ? std::strchr("ORbNrH", line_[0]) != nullptr : line_[0] != 'P';
    if (takes_numbers && byte != '\r') continue;
    obey({line_.data(), line_size_}, now);
    line_size_ = 0;
  }
}

void SimPolhemus::obey(std::span<const std::uint8_t> command, Nanoseconds now) noexcept {
  const std::string_view text(reinterpret_cast<const char*>(command.data()), command.size());
  const bool fastrak = model_ == polhemus::Model::fastrak;
  if (text == (fastrak ? "c" : "P")) continuous_ = false;
  if (text == (fastrak ? "f" : "F1\r")) binary_ = true;
  if (text == (fastrak ? "F" : "F0\r")) binary_ = false;
  if (text == (fastrak ? "C" : "C\r")) continuous_ = true;
  if (std::string_view(fastrak ? "cfFCU" : "PFCU").find(text[0]) != std::string_view::npos || set_frame(text))
    return;
  if (text.size() < 3 || text[0] != 'O') {
    constexpr std::string_view error = "*ERROR* Invalid Command\r\n";
    return send({reinterpret_cast<const std::uint8_t*>(error.data()), error.size()}, now);
  }
  const std::size_t comma = text.find(',');
  std::size_t station = 0;
  for (std::size_t i = 1; i < comma && i < 4 && i < text.size(); ++i)
    station = 10 * station + static_cast<std::size_t>(text[i] - '0');
  if (comma == std::string_view::npos || station >= has_format_.size()) return;
  has_format_[station] = text.substr(comma) == (fastrak ? ",2,11,0\r" : ",2,7,8,0\r");
}

/// Handles commands that set a frame: R, b, N, r, H of a Fastrak, ^R, ^B, N, G, H of a Liberty; returns false
/// for others. Only resets and the hemisphere have an effect.
bool SimPolhemus::set_frame(std::string_view text) noexcept {
  const bool fastrak = model_ == polhemus::Model::fastrak;
  const std::size_t kind = std::string_view(fastrak ? "RbNrH" : "\x12\x02NGH").find(text[0]);
  if (kind == std::string_view::npos) return false;
  const std::size_t comma = text.find(',');
  const bool zeros = text.substr(std::min(comma, text.size())).starts_with(",0,0,0\r") || text == "G0,0,0\r";
  for (std::size_t i = 0; i < num_tools_; ++i) {
    const bool all = kind == 3 && !fastrak;
    if (!all && text[1] != '*' && text[1] - '0' != static_cast<int>(stations_[i])) continue;
    if (kind == 0) saved_[i].X_alignment = {};
    if (kind == 1) saved_[i].boresight = Quat::Identity();
    if (kind == 2 && zeros) saved_[i].tip = Vec3::Zero();
    if (kind == 3 && zeros) saved_[i].source = Quat::Identity();
    if (kind != 4 || comma == std::string_view::npos) continue;
    const char* at = text.data() + comma;
    for (Eigen::Index k = 0; k < 3 && *at == ','; ++k) {
      char* end = nullptr;
      hemispheres_[i][k] = std::strtod(at + 1, &end);
      at = end;
    }
  }
  return true;
}

Pose SimPolhemus::reported(std::size_t tool) const noexcept {
  const Saved& saved = saved_[tool];
  const Pose& X = measurement().poses[tool];
  Pose out{.p = X.p + X.q * saved.tip, .q = X.q * saved.boresight};
  if (half_space_ && hemispheres_[tool].dot(out.p) < 0) out.p = -out.p;
  out.p = saved.X_alignment.q.conjugate() * (saved.source * out.p - saved.X_alignment.p);
  out.q = saved.X_alignment.q.conjugate() * saved.source * out.q;
  return out;
}

void SimPolhemus::measured(Nanoseconds now) noexcept {
  if (!continuous_) return;
  if (!binary_ || text_only_) {
    for (std::size_t i = 0; i < num_tools_; ++i) {
      std::array<char, 64> text{};
      const Vec3 p = reported(i).p / 0.0254;
      const int size = std::snprintf(text.data(), text.size(), "%02u %7.2f%7.2f%7.2f\r\n",
                                     unsigned{stations_[i]}, p.x(), p.y(), p.z());
      send({reinterpret_cast<const std::uint8_t*>(text.data()), static_cast<std::size_t>(size)}, now);
    }
    return;
  }
  for (std::size_t i = 0; i < num_tools_; ++i) {
    if (!has_format_[stations_[i]] || faults.missing[i] || faults.disabled[i]) continue;
    std::array<std::uint8_t, polhemus::max_record_size> bytes{};
    const polhemus::Record record{.model = model_,
                                  .station = stations_[i],
                                  .X_TH = reported(i),
                                  .t_ms = static_cast<std::uint32_t>(measurement().t / 1'000'000)};
    send(polhemus::make_record(record, bytes), now);
  }
}

}  // namespace godobject
