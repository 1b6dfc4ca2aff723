// Traces of a run as CSV, in the world frame, SI: the run itself, its contacts, and the nodes of nets. Every
// number is printed so that the same double is read back. Columns of the run itself, in this order:
//   t
//   per body                        <body>.x y z qw qx qy qz vx vy vz wx wy wz
//   per driven body                 <body>.coupling.fx fy fz tx ty tz, <body>.feedback.fx .. tz
//   per driven body, its target     <body>.target.x y z qw qx qy qz
//   per joint                       <joint>.fx fy fz tx ty tz
//   per body with contacts          <body>.contact.fx .. tz
//   devices that grip bodies        held, hand.fx .. tz
//   always                          penetration
//   scenes with contacts            contacts, contact_residual
//   scenes with nets                net_contacts, net_penetration, net_stretch, net_iterations, net_residual
//   always                          energy, energy_balance, fault, limited, rig_fault
//   buses or trackers               t_bus
//   per joint, its coordinates      <joint>.q, or .q1 and .q2
//   per target                      <target>.engaged; relative devices: <target>.clutch
//   relative or gripping devices    the device's pose <target>.device.x .. qz
//   admittance devices              the hand's wrench <target>.hand.fx .. tz
//   per joint of the device         device.<joint>.q
//   per drive                       drive.<joint>.torque, drive.<joint>.generated
// The columns from t_bus on have all that a motion of the trace requires, and the commands.
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
#include "platform/engine/engine.h"
#include "platform/scene/net/params.h"
#include "platform/scene/scene.h"
#include "platform/scene/text/csv.h"
#include "platform/session/record.h"

namespace godobject {

struct TraceBody {
  Pose X_WB;
  Twist V_WB;
  Wrench contact;  // sum of its contact wrenches, about its origin
};

/// Columns of a driven body, in the order of driven_bodies().
struct TraceDriven {
  Wrench coupling;  // wrench on the body, about its origin
  Wrench feedback;  // wrench on the hand, about the target's origin
  Pose X_WD;        // the target
};

/// Columns of the whole scene.
struct TraceScene {
  ContactReport contacts{};
  NetReport nets{};
  double net_stretch = 0;                 // l / l_0 of the most stretched spring
  std::optional<std::size_t> held{};      // index of the held body
  Wrench hand{};                          // displayed, about the device's origin
  double energy = 0, energy_balance = 0;  // J, see EnergyReport
};

/// Columns of the devices. Each span is as long as in CycleRecord; shorter ones are filled with zeros.
struct TraceDevices {
  double t_bus = 0;  // s, start of the period on the clock of the record
  std::span<const TargetSample> targets{};
  std::span<const double> joint_q{}, device_q{}, drive_torque{}, drive_energy{};
};

/// Bits of Fault, Limited and RigFault as unsigned numbers.
struct TraceBits {
  std::uint32_t fault = 0, limited = 0, rig_fault = 0;
};

/// Device columns in the trace of a scene.
struct TraceDeviceColumns {
  bool t_bus = false, clutch = false, poses = false, wrenches = false;
  std::size_t num_targets = 0, num_coordinates = 0, num_device_joints = 0, num_drives = 0;
};
TraceDeviceColumns device_columns(const SceneConfig& scene);

/// Writes rows into a buffer, and the buffer to the file when it is full. Not for the real-time thread.
class TraceWriter {
 public:
  /// rows: destination, a file or a sink.
  TraceWriter(CsvRows rows, const SceneConfig& scene);

  /// bodies, driven, joints: as many as the scene has bodies, driven bodies and joints, in their order.
  /// joints: wrench of each on its child, at its anchor there.
  void row(double t, std::span<const TraceBody> bodies, std::span<const TraceDriven> driven,
           std::span<const Wrench> joints, const TraceScene& scene, const TraceBits& bits,
           const TraceDevices& devices = {});
  /// Writes buffered rows. Returns false if anything was not written.
  [[nodiscard]] bool close() { return file_.close(); }

 private:
  void pose(const Pose& X);
  void wrench(const Wrench& F);
  void numbers(std::span<const double> x, std::size_t count);
  void row_of(const TraceDevices& devices);

  CsvRows file_;
  std::vector<std::size_t> touchable_;    // bodies with contact columns
  bool contacts_ = false, nets_ = false;  // true if the scene has any
  bool grips_ = false;                    // true if its device grips bodies
  TraceDeviceColumns device_columns_;
};

/// Returns the columns of the header line.
std::vector<std::string> trace_columns(const SceneConfig& scene);
/// Suffixes of the columns of a pose and of a wrench.
inline constexpr std::array pose_columns{"x", "y", "z", "qw", "qx", "qy", "qz"};
inline constexpr std::array wrench_columns{"fx", "fy", "fz", "tx", "ty", "tz"};

// Contacts of a run: a row for each contact with a force in a step. Columns:
//   t
//   body, on      names; for a node the name of its net
//   x y z         contact point
//   nx ny nz      normal, pointing away from `on`
//   fx fy fz      force on `body`

/// Writer of contacts. Not for the real-time thread.
class ContactTraceWriter {
 public:
  ContactTraceWriter(CsvRows rows, const SceneConfig& scene);

  void rows(double t, std::span<const ContactView> contacts);
  /// Writes buffered rows. Returns false if anything was not written.
  [[nodiscard]] bool close() { return file_.close(); }

 private:
  CsvRows file_;
  std::vector<std::string> bodies_, obstacles_,
      nodes_;  // name of each body, of each surface of the world, of each node's net
};

// Positions of the nodes of nets: a row per frame, with t and for every node <net>.<number>.x y z. Numbers
// are those of the net's surface, in the order of Engine::nets().

/// Writer of nodes. Not for the real-time thread.
class NetTraceWriter {
 public:
  NetTraceWriter(CsvRows rows, const SceneNets& nets);

  void row(double t, std::span<const Vec3> nodes);
  /// Writes buffered rows. Returns false if anything was not written.
  [[nodiscard]] bool close() { return file_.close(); }

 private:
  CsvRows file_;
};

/// Returns the columns of the header line.
std::vector<std::string> net_trace_columns(const SceneNets& nets);

}  // namespace godobject
