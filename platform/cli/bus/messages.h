// Messages on the buses. The text of a frame is that of CANopen, or of the protocol of the scene's drives.
// The table has count, period and latest value of each message.
#pragma once

#include <array>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "hal/can/timing.h"
#include "hal/drive/link.h"
#include "hal/rig/params.h"

namespace godobject {

struct MessageText {
  std::string name;   // "TPDO1 of base encoder"; empty: not a message of the bus's protocol
  std::string value;  // "0.1234 rad"; empty: not decoded
};

class MessageDecoder {
 public:
  /// Decodes CANopen (CiA 301), without names of nodes.
  MessageDecoder() = default;
  /// Decodes the messages of bus `bus` of the rig with the names of its nodes. The rig must outlive the
  /// decoder.
  MessageDecoder(const RigParams& rig, std::size_t bus);

  /// Decodes any frame.
  MessageText decode(const CanFrame& frame) const;

 private:
  struct Node {
    const EncoderParams* encoder = nullptr;
    const DriveParams* drive = nullptr;
    const ButtonParams* button = nullptr;
  };

  std::string node_name(std::uint8_t id) const;
  MessageText decode_drive_protocol(const CanFrame& frame) const;
  MessageText decode_node_message(const CanFrame& frame, std::uint8_t node) const;
  std::string decode_tpdo(const CanFrame& frame, int number, std::uint8_t id) const;
  std::string decode_drive(const CanFrame& frame, int number, const DriveParams& drive) const;
  std::string coordinate(std::int64_t counts, const Calibration& calibration, const std::string& joint) const;

  const RigParams* rig_ = nullptr;
  std::array<Node, canopen::max_node_id + 1> nodes_{};
  std::uint8_t host_ = 0;                             // node id; 0: unknown
  DriveText (*describe_)(const CanFrame&) = nullptr;  // protocol of the bus's drives; null: CANopen
};

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
