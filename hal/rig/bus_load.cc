#include "hal/rig/bus_load.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "hal/can/timing.h"
#include "hal/canopen/cia401.h"
#include "hal/canopen/cia406.h"
#include "hal/drive/link.h"

namespace godobject {
namespace {

/// Collects the messages of one bus.
class Messages {
 public:
  Messages(const BusParams& bus, double cycle_s, const BusLoadParams& params)
      : rates_{.nominal = bus.bit_rate, .data = bus.data_bit_rate > 0 ? bus.data_bit_rate : bus.bit_rate},
        cycle_s_(cycle_s),
        params_(params) {}

  void add_host() {
    add("SYNC", canopen::make_sync(), cycle_s_);
    add("host heartbeat", heartbeat(params_.host_node_id),
        params_.host_heartbeat_period_s.value_or(params_.heartbeat_period_s));
  }

  void add_encoder(const EncoderParams& encoder) {
    add(encoder.joint + " position", cia406::make_position(encoder.node_id, 0), cycle_s_);
    add(encoder.joint + " encoder heartbeat", heartbeat(encoder.node_id), params_.heartbeat_period_s);
  }

  void add_button(const ButtonParams& button) {
    const std::string name = "button node " + std::to_string(button.node_id);
    add(name + " inputs", cia401::make_inputs(button.node_id, 0), params_.button_event_period_s);
    add(name + " heartbeat", heartbeat(button.node_id), params_.heartbeat_period_s);
  }

  void add_drive(const DriveParams& drive) {
    const auto link = make_drive_link(drive, cycle_s_);
    for (const CyclicMessage& m : link->messages(cycle_s_, params_.drive_event_period_s))
      add(drive.joint + " " + m.what, m.frame, m.period_s);
    if (bus_protocol(drive.protocol).canopen)
      add(drive.joint + " drive heartbeat", heartbeat(drive.node_id), params_.heartbeat_period_s);
  }

  BusLoad sum(const std::string& name) && {
    // arbitration compares the first 11 bits, then a standard frame precedes an extended one
    std::ranges::stable_sort(messages_, {}, [](const BusMessage& m) {
      return m.extended ? std::tuple(m.cob_id >> 18, 1, m.cob_id & 0x3FFFFu) : std::tuple(m.cob_id, 0, 0u);
    });
    BusLoad load{.bus = name};
    for (const BusMessage& m : messages_) {
      load.nominal_percent += 100 * m.nominal_s / m.period_s;
      load.worst_percent += 100 * m.worst_s / m.period_s;
    }
    load.messages = std::move(messages_);
    return load;
  }

 private:
  /// Adds a cyclic message. period_s: s; 0: never sent.
  void add(std::string name, const CanFrame& frame, double period_s) {
    if (!(period_s > 0)) return;
    const FrameBits nominal = nominal_bits(frame), worst = worst_bits(frame);
    messages_.push_back({.name = std::move(name),
                         .cob_id = frame.id,
                         .period_s = period_s,
                         .nominal_bits = nominal.total(),
                         .worst_bits = worst.total(),
                         .extended = frame.extended,
                         .nominal_s = seconds(nominal),
                         .worst_s = seconds(worst)});
  }

  double seconds(const FrameBits& bits) const {
    return bits.nominal_rate / rates_.nominal + bits.data_rate / rates_.data;
  }

  static CanFrame heartbeat(std::uint8_t node) {
    return canopen::make_heartbeat(node, canopen::NmtState::operational);
  }

  BitRates rates_;
  double cycle_s_;
  BusLoadParams params_;
  std::vector<BusMessage> messages_;
};

bool first_of_its_node(const RigParams& rig, const ButtonParams& button) {
  const auto same = [&](const ButtonParams& b) { return b.bus == button.bus && b.node_id == button.node_id; };
  return &*std::ranges::find_if(rig.buttons, same) == &button;
}

}  // namespace

std::vector<BusLoad> bus_load(const RigParams& rig, double cycle_s, const BusLoadParams& params) {
  std::vector<BusLoad> loads;
  for (std::size_t bus = 0; bus < rig.buses.size(); ++bus) {
    Messages messages(rig.buses[bus], cycle_s, params);
    if (bus_protocol(protocol_of_bus(rig, bus)).canopen) messages.add_host();
    for (const EncoderParams& encoder : rig.encoders)
      if (encoder.bus == bus) messages.add_encoder(encoder);
    for (const DriveParams& drive : rig.drives)
      if (drive.bus == bus) messages.add_drive(drive);
    for (const ButtonParams& button : rig.buttons)
      if (button.bus == bus && first_of_its_node(rig, button)) messages.add_button(button);
    loads.push_back(std::move(messages).sum(rig.buses[bus].name));
  }
  return loads;
}

BusLoadParams usual_load(const RigParams& rig) noexcept {
  constexpr double usual_s = 0.1;
  constexpr double resolution_s = 1e-3;  // resolution of object 1017h
  constexpr double per_timeout = 5;      // even the slowest node then sends two per timeout
  BusLoadParams load;
  // The host's heartbeat may be fast for drives that supervise it. Heartbeats of the nodes need not be as
  // fast.
  const double period_s = std::max(usual_s, rig.heartbeat_period_s);
  load.heartbeat_period_s = std::max(resolution_s, std::min(period_s, rig.heartbeat_timeout_s / per_timeout));
  load.host_heartbeat_period_s = std::min(rig.heartbeat_period_s, load.heartbeat_period_s);
  load.host_node_id = rig.host_node_id;
  return load;
}

}  // namespace godobject
