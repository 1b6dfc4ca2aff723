#include "platform/cli/bus/message_table.h"

#include <algorithm>
#include <cstdio>

namespace godobject {
namespace {

constexpr double ns = 1e-9;

std::string hexadecimal(const CanFrame& frame) {
  if (frame.remote) return "remote";
  constexpr std::size_t max_shown = 16;  // bytes that fit into a line
  std::string text;
  std::array<char, 4> byte{};
  for (std::size_t i = 0; i < std::min<std::size_t>(frame.size, max_shown); ++i) {
    std::snprintf(byte.data(), byte.size(), i == 0 ? "%02X" : " %02X", static_cast<unsigned>(frame.data[i]));
    text += byte.data();
  }
  return frame.size > max_shown ? text + " .." : text;
}

}  // namespace

void MessageStatistics::add(const ReceivedFrame& received) noexcept {
  if (count == 0) {
    first_ns = received.t_ns;
  } else {
    const Nanoseconds period = received.t_ns - last_ns;
    period_min_ns = count == 1 ? period : std::min(period_min_ns, period);
    period_max_ns = std::max(period_max_ns, period);
  }
  last_ns = received.t_ns;
  last = received.frame;
  ++count;
}

double MessageStatistics::period_s() const noexcept {
  return count < 2 ? 0 : ns * static_cast<double>(last_ns - first_ns) / static_cast<double>(count - 1);
}

double MonitoredBus::load_percent() const noexcept {
  return last_ns > first_ns ? 100 * static_cast<double>(on_wire_ns) / static_cast<double>(last_ns - first_ns)
                            : 0;
}

void MessageTable::add(std::size_t bus, const ReceivedFrame& received) {
  MonitoredBus& b = buses_[bus];
  if (b.count++ == 0) b.first_ns = received.t_ns;
  b.last_ns = received.t_ns;
  b.on_wire_ns += duration_ns(exact_bits(received.frame), b.bit_rates);
  const CanFrame& frame = received.frame;
  messages_[{bus, frame.extended, frame.id, frame.remote}].add(received);
}

std::vector<std::string> MessageTable::lines() const {
  std::vector<std::string> lines;
  std::array<char, 320> line{};
  std::snprintf(line.data(), line.size(), "%-8s %8s  %-34s %9s %9s %25s  %-24s %s", "bus", "id", "message",
                "count", "per s", "period ms min/mean/max", "data", "says");
  lines.emplace_back(line.data());
  for (const auto& [key, message] : messages_) {
    const auto& [bus, extended, id, remote] = key;
    const MessageText text = buses_[bus].decoder.decode(message.last);
    const double period_s = message.period_s();
    std::array<char, 40> period{};
    if (message.count > 1)
      std::snprintf(period.data(), period.size(), "%.3f %.3f %.3f",
                    1e-6 * static_cast<double>(message.period_min_ns), 1e3 * period_s,
                    1e-6 * static_cast<double>(message.period_max_ns));
    std::snprintf(line.data(), line.size(), "%-8s %8.*X  %-34s %9llu %9.1f %25s  %-24s ",
                  buses_[bus].name.c_str(), extended ? 8 : 3, static_cast<unsigned>(id), text.name.c_str(),
                  static_cast<unsigned long long>(message.count), period_s > 0 ? 1 / period_s : 0.0,
                  period.data(), hexadecimal(message.last).c_str());
    lines.push_back(std::string(line.data()) + text.value);
  }
  return lines;
}

}  // namespace godobject
