// One bus of this machine, for a verb that sends requests on it and waits for the answers. On it one CANopen
// node is read and written by SDO, one transfer at a time, not in real time.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/canopen/object.h"
#include "hal/canopen/sdo/client.h"
#include "platform/cli/program.h"
#include "platform/linux/bus/bus.h"
#include "platform/rt/signals.h"

namespace godobject {

struct DialogueOptions {
  std::string bus;
  double bit_rate = 1e6;  // bit/s
  double timeout = 1;     // s, per answer

  Nanoseconds timeout_ns() const { return static_cast<Nanoseconds>(1e9 * timeout); }
};

/// Adds --bus, --bit-rate and --timeout.
void add_dialogue_options(CLI::App& verb, DialogueOptions& options);

class BusDialogue {
 public:
  /// Opens the bus to receive the frames that match a filter. On failure prints the reason to stderr and
  /// returns its exit code.
  ExitCode open(const DialogueOptions& options, std::span<const CanFilter> wanted);
  /// As above, for answers that share one COB-ID.
  ExitCode open(const DialogueOptions& options, std::uint32_t cob_id) {
    const CanFilter answers{.id = cob_id, .mask = 0x7FF};
    return open(options, {&answers, 1});
  }

  /// Runs until busy() returns false: calls on_frame for each frame, then poll, at least once per
  /// millisecond.
  void run(const std::function<bool()>& busy, const std::function<void(const CanFrame&)>& on_frame,
           const std::function<void(Nanoseconds, CanBus&)>& poll);

  /// Encodes the frames for the open bus.
  LastWords last_words(std::span<const CanFrame> frames) const;

  /// Returns the trouble of the bus after "; ", or an empty string.
  std::string trouble() const;

 private:
  std::unique_ptr<LinuxBus> bus_;
};

struct NodeOptions {
  DialogueOptions dialogue;
  int node = 1;
  int host_node = 127;  // host_node_id of the scene

  sdo::Client make_client() const { return sdo::Client(node_id(), dialogue.timeout_ns()); }
  std::uint8_t node_id() const { return static_cast<std::uint8_t>(node); }
};

/// Adds --bus, --bit-rate, --timeout, --node and --host-node.
void add_node_options(CLI::App& verb, NodeOptions& options);

struct TypedObject {
  canopen::ObjectAddress address{};
  canopen::ObjectType type = canopen::ObjectType::u32;
};

/// SDO client of one node. Each call waits for the node's answer for at most --timeout.
class NodeDialogue {
 public:
  explicit NodeDialogue(const NodeOptions& options) : options_(options), client_(options.make_client()) {}

  /// Opens the bus and listens for half a second. If the bus cannot be opened, prints the reason to stderr
  /// and returns its exit code.
  ExitCode open();
  /// Returns the traffic since open() that reveals another host on the bus; empty: none, or from this
  /// program.
  const std::string& host_seen() const { return host_seen_; }

  /// Return none or false on failure; failure() has the reason.
  std::optional<std::int64_t> read(const TypedObject& object);
  std::optional<std::string> read_text(canopen::ObjectAddress address);
  bool write(const TypedObject& object, std::int64_t value);
  /// Returns the request that writes the value, for LastResort. Requires an open bus.
  LastWords last_words(const TypedObject& object, std::int64_t value) const;
  /// True if the last transfer failed because the node does not have the object.
  bool was_absent() const;
  /// Returns why the last transfer failed: object, cause, check to make; empty after a success.
  const std::string& failure() const { return failure_; }
  /// Prints failure() to stderr.
  ExitCode report() const;

  /// Sends a command of network management to this node alone.
  void command(canopen::NmtCommand command);
  /// Switches the host's heartbeat on or off. While on it is sent at once, then every 100 ms in each wait of
  /// this class.
  void send_heartbeats(bool on) {
    heartbeats_ = on;
    t_heartbeat_ns_ = 0;
  }
  void wait(Nanoseconds duration);
  int node() const { return options_.node; }
  int host_node() const { return options_.host_node; }

 private:
  bool transfer(canopen::ObjectAddress address, const std::string& what);
  void on_frame(const CanFrame& frame);
  void poll(Nanoseconds now, CanBus& bus);

  const NodeOptions& options_;
  BusDialogue bus_;
  sdo::Client client_;
  std::string failure_, host_seen_;
  std::optional<CanFrame> to_send_;
  bool heartbeats_ = false;
  Nanoseconds t_heartbeat_ns_ = 0;
};

// Text form of the objects of a CANopen dictionary, for `godobject sdo`.

/// Parses "6077", "6077h" or "0x6077", each with or without ":00". All are hexadecimal, as in manuals.
std::optional<canopen::ObjectAddress> parse_object_address(std::string_view text);

/// Returns the values of --type: the names of ObjectType, and "hex".
std::vector<std::string> value_type_names();

/// Returns the type of this name if its values are numbers.
std::optional<canopen::ObjectType> number_type(const std::string& name);

/// Returns the bytes of a value of this type; "hex" accepts "0A 00" or "0A00". On failure sets `error`.
std::optional<std::vector<std::uint8_t>> parse_value(std::string_view text, const std::string& type,
                                                     std::string& error);

/// Formats the bytes as a value of this type, or, with an empty type, as every type of their size. Sets
/// `error` if the bytes cannot be of the type.
std::optional<std::string> format_value(std::span<const std::uint8_t> bytes, const std::string& type,
                                        std::string& error);

}  // namespace godobject
