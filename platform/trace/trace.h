// The trace of a run as CSV: t, per body <body>.x y z qw qx qy qz vx vy vz wx wy wz, per driven body
// <body>.coupling.fx fy fz tx ty tz and <body>.feedback.fx .. tz, for the same bodies the target they were
// pulled to, <body>.target.x y z qw qx qy qz, per joint <joint>.fx fy fz tx ty tz, per body that can be touched
// <body>.contact.fx .. tz, where the device takes hold of bodies held and hand.fx .. tz, then penetration, in scenes
// with contacts contacts and contact_residual, with nets net_contacts, net_penetration, net_stretch, net_iterations and
// net_residual, then energy, energy_balance, then fault, limited and rig_fault. Then all that a motion of the trace needs and
// what was commanded: t_bus where the device has buses or trackers, per joint its coordinates <joint>.q, or .q1 and .q2, per
// target <target>.engaged, of relative devices .clutch, of those and of devices that take hold the device's pose
// <target>.device.x .. qz, of admittance devices the hand's wrench <target>.hand.fx .. tz, per joint of the device
// device.<joint>.q, per drive drive.<joint>.torque.
// World frame, SI; every number reads back as the same double.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/contact/contact.h"
#include "core/net/net.h"
#include "platform/scene/scene.h"
#include "platform/session/record.h"
#include "platform/trace/csv_rows.h"

namespace godobject {

struct TraceBody {
  Pose X_WB;
  Twist V_WB;
  Wrench contact;  // of all its contacts, about its origin
};

/// What a row says of a driven body, in the order of driven_bodies().
struct TraceDriven {
  Wrench coupling;  // on the body, about its origin
  Wrench feedback;  // on the hand, about the target's origin
  Pose X_WD;        // the target
};

/// What a row says of the scene as a whole.
struct TraceScene {
  ContactReport contacts{};
  NetReport nets{};
  double net_stretch = 0;                 // l / l_0 of the spring that is stretched most
  std::optional<std::size_t> held{};      // index of the body that the device holds
  Wrench hand{};                          // shown to the hand, about the device's origin
  double energy = 0, energy_balance = 0;  // J, see EnergyReport
};

/// The devices' part of a row, each span as long as CycleRecord has it; shorter ones are filled up with zeros.
struct TraceDevices {
  double t_bus = 0;  // s, when the period began, on the clock of the record
  std::span<const TargetSample> targets{};
  std::span<const double> joint_q{}, device_q{}, drive_torque{};
};

/// The bits of Fault, Limited and RigFault as unsigned numbers.
struct TraceBits {
  std::uint32_t fault = 0, limited = 0, rig_fault = 0;
};

/// Which of the devices' columns a trace of a scene has.
struct TraceDeviceColumns {
  bool t_bus = false, clutch = false, poses = false, wrenches = false;
  std::size_t num_targets = 0, num_coordinates = 0, num_device_joints = 0, num_drives = 0;
};
TraceDeviceColumns device_columns(const SceneConfig& scene);

/// Writes rows into a buffer and the buffer to the file when it is full. Not for the real-time thread.
class TraceWriter {
 public:
  /// rows: into a file, or wherever they are to go.
  TraceWriter(CsvRows rows, const SceneConfig& scene);

  /// bodies, driven, joints: as many as the scene has bodies, driven bodies and joints, in their order.
  /// joints: what each does to its child, at its anchor there.
  void row(double t, std::span<const TraceBody> bodies, std::span<const TraceDriven> driven,
           std::span<const Wrench> joints, const TraceScene& scene, const TraceBits& bits,
           const TraceDevices& devices = {});
  /// Writes what is left. False when anything did not reach the file.
  [[nodiscard]] bool close() { return file_.close(); }

 private:
  void pose(const Pose& X);
  void wrench(const Wrench& F);
  void numbers(std::span<const double> x, std::size_t count);
  void row_of(const TraceDevices& devices);

  CsvRows file_;
  std::vector<std::size_t> touchable_;    // bodies with contact columns
  bool contacts_ = false, nets_ = false;  // the scene has some
  bool grips_ = false;                    // its device takes hold of bodies
  TraceDeviceColumns device_columns_;
};

/// The header line's columns.
std::vector<std::string> trace_columns(const SceneConfig& scene);
/// Suffixes of the columns of a pose and of a wrench.
inline constexpr std::array pose_columns{"x", "y", "z", "qw", "qx", "qy", "qz"};
inline constexpr std::array wrench_columns{"fx", "fy", "fz", "tx", "ty", "tz"};

}  // namespace godobject
