// Table of the messages seen on the buses: count, period and latest value of each.
#pragma once

#include <array>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "hal/can/timing.h"
#include "platform/cli/bus/message_decoder.h"

namespace godobject {

struct MessageStatistics {
  std::uint64_t count = 0;
  Nanoseconds first_ns = 0, last_ns = 0;
  Nanoseconds period_min_ns = 0, period_max_ns = 0;  // from the second frame on
  CanFrame last{};

  void add(const ReceivedFrame& received) noexcept;
  /// Returns the mean time between two frames, s; 0 for fewer than two frames.
  double period_s() const noexcept;
};

/// A monitored bus and its totals.
struct MonitoredBus {
  std::string name;
  BitRates bit_rates;
  MessageDecoder decoder;

  std::uint64_t count = 0;
  Nanoseconds first_ns = 0, last_ns = 0;
  Nanoseconds on_wire_ns = 0;  // time of the frames on the wire at the bus's bit rate

  /// Returns the load between the first and the last frame; 0 for fewer than two frames.
  double load_percent() const noexcept;
};

class MessageTable {
 public:
  explicit MessageTable(std::vector<MonitoredBus> buses) : buses_(std::move(buses)) {}

  void add(std::size_t bus, const ReceivedFrame& received);
  const MonitoredBus& bus(std::size_t i) const { return buses_[i]; }
  std::size_t num_buses() const noexcept { return buses_.size(); }

  /// Returns a heading and a line per message, sorted by bus, then identifier, standard before extended. A
  /// remote frame is a message of its own.
  std::vector<std::string> lines() const;

 private:
  using Key = std::tuple<std::size_t, bool, std::uint32_t, bool>;  // bus, extended, identifier, remote

  std::vector<MonitoredBus> buses_;
  std::map<Key, MessageStatistics> messages_{};
};

}  // namespace godobject
