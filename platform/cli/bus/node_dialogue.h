// One CANopen node on one bus of this machine, asked and told by SDO, one transfer at a time, not in real time.
#pragma once

#include <optional>
#include <string>

#include "hal/canopen/sdo/client.h"
#include "platform/cli/bus/dialogue.h"
#include "platform/rt/last_resort.h"

namespace godobject {

struct NodeOptions {
  DialogueOptions dialogue;
  int node = 1;
  int host_node = 127;  // the scene's host_node_id

  sdo::Client make_client() const { return sdo::Client(node_id(), dialogue.timeout_ns()); }
  std::uint8_t node_id() const { return static_cast<std::uint8_t>(node); }
};

/// --bus, --bit-rate, --timeout, --node and --host-node.
void add_node_options(CLI::App& verb, NodeOptions& options);

struct TypedObject {
  canopen::ObjectAddress address{};
  canopen::ObjectType type = canopen::ObjectType::u32;
};

/// Each call waits for the node's answer, --timeout at the longest.
class NodeDialogue {
 public:
  explicit NodeDialogue(const NodeOptions& options) : options_(options), client_(options.make_client()) {}

  /// Opens the bus and listens for half a second. Reports to stderr and returns other than ok where the bus
  /// cannot be opened.
  ExitCode open();
  /// What has been heard since open() of a host that runs the bus; empty: nothing, or it is this program.
  const std::string& host_seen() const { return host_seen_; }

  /// None, false: failure() says why.
  std::optional<std::int64_t> read(const TypedObject& object);
  std::optional<std::string> read_text(canopen::ObjectAddress address);
  bool write(const TypedObject& object, std::int64_t value);
  /// The request to write it, for LastResort. The bus is open.
  LastWords last_words(const TypedObject& object, std::int64_t value) const;
  /// The last transfer failed because the node does not have the object.
  bool was_absent() const;
  /// Why the last transfer failed: object, what happened, what to check; empty: it went well.
  const std::string& failure() const { return failure_; }
  /// Prints failure() to stderr.
  ExitCode report() const;

  /// Network management of this node alone.
  void command(canopen::NmtCommand command);
  /// From now on, whenever this waits, the host's heartbeat is sent: at once, then each 100 ms.
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

}  // namespace godobject
