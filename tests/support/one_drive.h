// A rig of one hinge with one simulated drive, without a scene.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "hal/rig/rig.h"
#include "sim/node/drive.h"

namespace godobject::test {

/// A hinge with nothing but one drive; the node on the wire is of the test's making.
class OneDrive {
 public:
  static constexpr Nanoseconds ms = 1'000'000;
  static constexpr double cycle_s = 1e-3;
  static constexpr std::uint8_t id = 7;
  using Make = std::function<std::unique_ptr<SimNode>(CanBus&, const DriveParams&)>;

  OneDrive(const DriveParams& drive, const Make& make) {
    params.buses = {{.name = "can0", .data_bit_rate = drive.protocol == DriveProtocol::moteus ? 5e6 : 0.0}};
    params.tree.joints = {{.name = "yaw"}};
    params.tree.handles = {{.body = "tool", .joint = "yaw", .X_LH = {Vec3(0.1, 0, 0), Quat::Identity()}}};
    params.drives = {drive};
    params.boot_timeout_s = 2;
    wire.emplace(SimWireParams{.rates = {.nominal = 1e6, .data = 5e6}});
    host.emplace(*wire);
    port.emplace(*wire);
    EXPECT_TRUE(host->open() && port->open());
    wire->set_observer({.on_frame =
                            [](void* context, const ReceivedFrame& received) {
                              static_cast<OneDrive*>(context)->frames.push_back(received);
                            },
                        .context = this});
    node = make(*port, drive);
    nodes = {node.get()};
    std::array<CanBus*, 1> buses{&*host};
    EXPECT_EQ(validate(params, cycle_s), std::vector<std::string>{});
    rig = std::make_unique<Rig>(params, cycle_s, buses);
    advance(*wire, nodes, ms / 2);
    now = ms;
    advance(*wire, nodes, now);
  }

  void cycle() {
    rig->sync(now);
    advance(*wire, nodes, now + 7 * ms / 10);
    rig->receive(wire->now());
    static_cast<void>(rig->read(wire->now()));
    report = rig->command({&F, 1}, wire->now());
    now += ms;
    advance(*wire, nodes, now);
  }
  /// Cycles until ready or a fault, at most those of the boot time-out and some.
  int boot() {
    rig->start(now);
    int count = 0;
    while (!rig->ready() && rig->state() != RigState::fault && count < 3000) {
      cycle();
      ++count;
    }
    return count;
  }

  RigParams params;
  std::optional<SimCanWire> wire;
  std::optional<SimCanPort> host, port;
  std::vector<ReceivedFrame> frames;
  std::unique_ptr<SimNode> node;
  std::vector<SimNode*> nodes;
  std::unique_ptr<Rig> rig;
  Nanoseconds now = 0;
  Wrench F{};
  CommandReport report;
};

inline DriveParams drive_of(DriveProtocol protocol) {
  DriveParams drive{.joint = "yaw", .protocol = protocol, .node_id = OneDrive::id};
  drive.torque_rate_Nm_per_s = 100;
  drive.calibration.counts_per_unit = 10000;
  if (protocol == DriveProtocol::odrive) drive.watchdog = DriveWatchdog::drive;
  return drive;
}

inline OneDrive::Make cia402_with(const SimDriveQuirks& quirks) {
  return [quirks](CanBus& bus, const DriveParams& drive) {
    return std::make_unique<SimDrive>(
        bus, SimDriveParams{.drive = drive, .quirks = quirks, .heartbeat_period_ns = 100 * OneDrive::ms});
  };
}

}  // namespace godobject::test
