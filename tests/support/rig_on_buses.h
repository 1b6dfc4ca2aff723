// A rig on scripted buses, and nodes that answer in every cycle as far as a test lets them.
#pragma once

#include <algorithm>
#include <deque>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "hal/canopen/cia401.h"
#include "hal/canopen/cia406.h"
#include "hal/drive/cia402.h"
#include "hal/rig/rig.h"
#include "tests/support/scripted_bus.h"
#include "tests/support/scripted_drive.h"

namespace godobject::test {

/// An encoder, a CiA 402 drive, a node of buttons, or a drive of another protocol.
struct ScriptedNode {
  NodeKind kind = NodeKind::encoder;
  std::size_t bus = 0;
  std::uint8_t id = 0;
  int every_nth_sync = 1;
  bool answers = true, sends_heartbeats = true;
  std::size_t delay = 0;    // of its answers, cycles
  std::int32_t counts = 0;  // position
  std::uint8_t inputs = 0;
  canopen::NmtState nmt = canopen::NmtState::operational;
  cia402::DriveState state = cia402::DriveState::switch_on_disabled;
  bool follows = true;            // it follows its commands; otherwise it ignores its controlwords, too
  std::uint16_t status_bits = 0;  // further bits of its statusword
  cia402::Command last_command{};
  std::shared_ptr<ScriptedDrive> drive{};  // not CANopen
  std::deque<bool> synced{};               // SYNCs without answer, the oldest first
  int num_syncs = 0;
};

/// Returns a row of hinges about one axis: the first ones with an encoder each, the others with a drive each.
/// The handle is 0.1 m from the axis. Encoders are nodes 1, 2, ... of the first bus, drives nodes 11, 12, ...
/// of the last.
inline RigParams row_of_hinges(int num_encoders, int num_drives,
                               DriveProtocol protocol = DriveProtocol::cia402, int num_buses = 1) {
  const bool canopen = protocol == DriveProtocol::cia402;
  RigParams rig;
  for (int i = 0; i < num_buses; ++i) rig.buses.push_back({.name = "can" + std::to_string(i)});
  if (protocol == DriveProtocol::moteus) rig.buses.back().data_bit_rate = 5e6;
  for (int i = 0; i < num_encoders + num_drives; ++i) {
    const std::string name = "hinge" + std::to_string(i);
    rig.tree.joints.push_back({.name = name});
    if (i < num_encoders) {
      rig.encoders.push_back({.joint = name,
                              .node_id = static_cast<std::uint8_t>(1 + i),
                              .calibration = {.counts_per_unit = 1000}});
      continue;
    }
    rig.drives.push_back({.joint = name,
                          .protocol = protocol,
                          .bus = static_cast<std::size_t>(num_buses - 1),
                          .node_id = static_cast<std::uint8_t>(11 + i - num_encoders),
                          .torque_max_Nm = 0.1,
                          .torque_rate_Nm_per_s = 1000,
                          .calibration = {.counts_per_unit = canopen ? 1000 : counts_per_motor_turn}});
  }
  rig.tree.handles = {
      {.body = "tool", .joint = rig.tree.joints.back().name, .X_LH = {Vec3(0.1, 0, 0), Quat::Identity()}}};
  return rig;
}

/// Returns a row of hinges with two encoders, the second on the second bus.
inline RigParams row_on_two_buses(int num_drives, DriveProtocol protocol = DriveProtocol::cia402,
                                  int num_buses = 2) {
  RigParams rig = row_of_hinges(2, num_drives, protocol, num_buses);
  rig.encoders[1].bus = 1;
  return rig;
}

/// Returns "identifier size: bytes" of each frame, hexadecimal.
inline std::vector<std::string> texts_of(const std::vector<CanFrame>& frames) {
  std::vector<std::string> texts;
  for (const CanFrame& frame : frames) {
    std::ostringstream text;
    text << std::hex << frame.id << (frame.remote ? " remote " : " ") << int{frame.size} << ":";
    for (const std::uint8_t byte : frame.bytes()) text << " " << int{byte};
    texts.push_back(text.str());
  }
  return texts;
}

class RigOnBuses {
 public:
  static constexpr Nanoseconds ms = 1'000'000, us = 1000;
  static constexpr Nanoseconds sync_ns = 48 * us;     // SYNC on the wire, without the intermission
  static constexpr Nanoseconds answer_ns = 250 * us;  // end of an answer, after its SYNC was queued
  static constexpr Nanoseconds read_ns = 500 * us;    // read() and command(), after sync()
  static constexpr double cycle_s = 1e-3;
  static constexpr int heartbeat_cycles = 10;

  explicit RigOnBuses(RigParams of_rig)
      : params(std::move(of_rig)),
        bus(params.buses.size()),
        pointers(pointers_to(bus)),
        rig(params, cycle_s, pointers),
        F(params.tree.handles.size()) {
    for (const EncoderParams& encoder : params.encoders) add({.bus = encoder.bus, .id = encoder.node_id});
    for (const DriveParams& drive : params.drives) {
      add({.kind = NodeKind::drive,
           .bus = drive.bus,
           .id = drive.node_id,
           .every_nth_sync = drive.status_every_nth_sync});
      if (drive.protocol == DriveProtocol::odrive)
        nodes.back().drive = std::make_shared<ScriptedOdrive>(drive.node_id);
      if (drive.protocol == DriveProtocol::moteus)
        nodes.back().drive = std::make_shared<ScriptedMoteus>(drive.node_id);
    }
    for (const ButtonParams& button : params.buttons) {
      const auto same = [&](const ScriptedNode& n) { return n.bus == button.bus && n.id == button.node_id; };
      if (std::ranges::none_of(nodes, same))
        add({.kind = NodeKind::button, .bus = button.bus, .id = button.node_id});
    }
  }

  ScriptedNode& encoder(std::size_t i = 0) { return nodes[i]; }
  ScriptedNode& drive(std::size_t i = 0) { return nodes[params.encoders.size() + i]; }
  ScriptedNode& button(std::size_t i = 0) { return nodes[params.encoders.size() + params.drives.size() + i]; }

  /// Delivers a frame at a time, ns.
  void receive(std::size_t on, const CanFrame& frame, Nanoseconds t_ns) {
    bus[on].to_receive.push_back({.frame = frame, .t_ns = t_ns});
  }
  /// Delivers a frame with the answers of this cycle.
  void receive(std::size_t on, const CanFrame& frame) { receive(on, frame, now + answer_ns); }

  void begin() {
    for (ScriptedBus& one : bus) one.sent.clear();
    rig.sync(now);
    for (ScriptedNode& node : nodes) answer(node);
  }
  void finish() {
    rig.receive(now + read_ns);
    sample = rig.read(now + read_ns);
    report = rig.command(F, now + read_ns);
    for (ScriptedNode& node : nodes) take_commands(node);
    now += ms;
    ++num_cycles;
  }
  void cycle() {
    begin();
    finish();
  }
  void cycles(int count) {
    for (int i = 0; i < count; ++i) cycle();
  }
  /// Cycles until the rig is in a state, at most `most`. Returns their number.
  int cycles_to(RigState state, int most = 2000) {
    int count = 0;
    for (; count < most && rig.state() != state; ++count) cycle();
    return count;
  }
  bool boot() {
    rig.start(now);
    cycles_to(RigState::ready, 500);
    return rig.state() == RigState::ready;
  }
  bool boot_and_arm() { return boot() && rig.arm(); }

  /// Number of frames with an identifier that the host sent in the last cycle.
  int sent(std::size_t on, std::uint32_t id) const {
    return static_cast<int>(std::ranges::count(bus[on].sent, id, &CanFrame::id));
  }

  const RigParams params;
  std::vector<ScriptedBus> bus;

  std::vector<CanBus*> pointers;
  Rig rig;
  std::vector<ScriptedNode> nodes;
  Nanoseconds now = 0;
  int num_cycles = 0;
  std::vector<Wrench> F;
  DeviceSample sample;
  CommandReport report;

 private:
  static std::vector<CanBus*> pointers_to(std::vector<ScriptedBus>& buses) {
    std::vector<CanBus*> out;
    for (ScriptedBus& one : buses) out.push_back(&one);
    return out;
  }
  void add(ScriptedNode node) { nodes.push_back(std::move(node)); }

  void answer(ScriptedNode& node) {
    const SendFrame send = [&](const CanFrame& frame) { receive(node.bus, frame); };
    const bool heartbeat_is_due = node.sends_heartbeats && num_cycles % heartbeat_cycles == 0;
    if (node.drive) {
      for (const CanFrame& frame : bus[node.bus].sent) node.drive->receive_from_host(frame);
      if (node.answers) node.drive->answer(send);
      if (heartbeat_is_due) node.drive->send_heartbeat(send);
      return;
    }
    node.synced.push_back(sent(node.bus, canopen::sync_cob_id) > 0);
    const bool due = node.synced.size() > node.delay && node.synced.front();
    while (node.synced.size() > node.delay) node.synced.pop_front();
    if (due && node.answers && node.kind == NodeKind::encoder)
      send(cia406::make_position(node.id, static_cast<std::uint32_t>(node.counts)));
    if (due && node.answers && node.kind == NodeKind::drive && ++node.num_syncs % node.every_nth_sync == 0)
      send(status_of(node));
    if (!heartbeat_is_due) return;
    if (node.kind == NodeKind::button && node.answers) send(cia401::make_inputs(node.id, node.inputs));
    send(canopen::make_heartbeat(node.id, node.nmt));
  }
  static CanFrame status_of(const ScriptedNode& node) {
    const unsigned follows = node.follows ? cia402::status_follows_command : 0u;
    return cia402::make_status(node.id, {.statusword = static_cast<std::uint16_t>(
                                             cia402::encode_state(node.state) | follows | node.status_bits),
                                         .position_counts = node.counts});
  }
  void take_commands(ScriptedNode& node) {
    if (node.kind != NodeKind::drive) return;
    for (const CanFrame& frame : bus[node.bus].sent) {
      // its requests were received at the beginning
      if (node.drive && !frame.remote && frame.id != moteus::request_id(node.id))
        node.drive->receive_from_host(frame);
      cia402::Command command;
      if (node.drive || cia402::parse_command(frame, node.id, command) != ParseResult::ok) continue;
      node.last_command = command;
      if (!node.follows) continue;
      switch (command.controlword) {
        case cia402::fault_reset_bit:
          if (node.state == cia402::DriveState::fault) node.state = cia402::DriveState::switch_on_disabled;
          break;
        case cia402::shutdown: node.state = cia402::DriveState::ready_to_switch_on; break;
        case cia402::switch_on: node.state = cia402::DriveState::switched_on; break;
        case cia402::enable_operation: node.state = cia402::DriveState::operation_enabled; break;
        default: break;
      }
    }
  }
};

}  // namespace godobject::test
