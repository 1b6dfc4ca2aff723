// Motion of the hand as a function of time. It gives the target of every driven body, or the wrench on it,
// and the switches of the device.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/body/target.h"
#include "hal/joint/kinematic_tree.h"
#include "platform/motion/curve.h"
#include "platform/scene/scene.h"
#include "platform/scene/text/csv.h"

namespace godobject {

/// Switches of the user: engaged or released, clutch open or closed.
struct MotionSwitches {
  bool engaged = true;
  bool clutch = true;  // relative devices only
};

/// Body that a scripted device shall hold.
struct HoldWish {
  enum class Kind : std::uint8_t { nothing, body, nearest };
  Kind kind = Kind::nothing;
  std::size_t body = 0;  // index of the body in the scene

  friend bool operator==(const HoldWish&, const HoldWish&) = default;
};

/// Returns the wish for the body of this name, see HoldConfig.
HoldWish hold_wish(const SceneConfig& scene, const std::string& name);

struct MotionResult;

/// Bodies are numbered as motion_targets() of the scene lists them. If the device grips bodies there is one,
/// the device itself. Evaluation does not allocate.
class Motion {
 public:
  /// Makes the scene's own [motion], which moves the device's joints, and by their handles the bodies, or the
  /// first driven body. All others rest at their start, as does the first in a scene without [motion].
  explicit Motion(const SceneConfig& scene);

  /// Reads a table with columns t (s, strictly increasing) and, for every driven body,
  ///   <body>.x, y, z, qw, qx, qy, qz   (m; unit quaternion), or
  ///   <body>.fx, fy, fz, tx, ty, tz    (N, N m; admittance devices), or
  ///   <joint> for every joint of the device (rad or m); its handles move their bodies, other bodies rest.
  /// Each may be combined with <body>.engaged and <body>.clutch (0 or 1). For a device that grips bodies its
  /// name replaces <body>. Columns hold (a name of HoldConfig; "-": nothing) and button (0 or 1) then replace
  /// <body>.engaged. Without columns of poses, wrenches or joints the scene's own [motion] is used; without
  /// hold its [[motion.hold]].
  ///
  /// Interpolation: platform/motion/curve.h. Before the first and after the last sample the target rests at
  /// the end pose, with the end wrench. Switches keep their value until the next sample, and before the first
  /// sample have its value.
  ///
  /// A trace of a run of this scene is such a table, see parse_motion_table().
  static MotionResult read(const std::string& path, const SceneConfig& scene);
  /// Parses a text as read() does.
  /// file: name in messages.
  static MotionResult parse(std::string_view csv, const std::string& file, const SceneConfig& scene);

  std::size_t num_bodies() const noexcept { return starts_.size(); }
  Target target(std::size_t body, double t) const noexcept;
  /// Returns the hand's wrench on an admittance device's body, in world axes about the body's origin.
  Wrench wrench(std::size_t body, double t) const noexcept;
  /// True for a motion of the device's joints. Then joints() returns them, and target(i, t) is the pose of
  /// the handle of body i.
  bool has_joints() const noexcept { return !joints_.empty() || !joint_sines_.empty(); }
  JointTarget joints(double t) const noexcept;
  /// Returns the switches; both are on without a column.
  MotionSwitches switches(std::size_t body, double t) const noexcept;
  /// Returns the wish at t; nothing without a column or a table of the scene.
  HoldWish hold(double t) const noexcept;
  /// True if the device's button is pressed.
  bool button(double t) const noexcept;
  /// Returns the time of the last sample, if target or wrench is a table.
  std::optional<double> end() const noexcept;

 private:
  friend class MotionReader;
  struct PoseCurve {
    VectorCurve<Vec3> p;
    RotationCurve q;
  };
  struct WrenchCurve {
    VectorCurve<Vec3> f, tau;
  };

  void take_holds(const SceneConfig& scene);

  std::vector<Pose> starts_;                   // one per driven body
  std::optional<MotionConfig> built_in_;       // motion of body 0
  std::vector<CoordinateMotion> joint_sines_;  // motions of the scene, one per joint of the device
  std::optional<KinematicTree> tree_;
  std::vector<std::optional<std::size_t>> handles_;  // handle of each driven body
  std::optional<TimeGrid> grid_;                     // times of a table, which fills one of:
  std::vector<PoseCurve> poses_;
  std::vector<WrenchCurve> wrenches_;
  std::vector<VectorCurve<double>> joints_;
  std::optional<TimeGrid> switch_grid_;                // times of a table with switches
  std::vector<std::vector<MotionSwitches>> switches_;  // per driven body, one per time of switch_grid_
  std::vector<bool> buttons_;                          // one per time of switch_grid_, or empty
  std::optional<TimeGrid> hold_grid_;
  std::vector<HoldWish> holds_;  // one per time of hold_grid_
};

/// Largest speed of any target, and its time.
struct MotionSpeed {
  std::size_t body = 0;
  double speed = 0, t = 0;  // m/s, s
};

/// Searches the first `duration` seconds with two samples per step on average, at times that are not
/// multiples of a period of the motion.
MotionSpeed fastest(const Motion& motion, double duration, double step);

struct MotionResult {
  std::optional<Motion> motion;             // absent if there are errors
  std::vector<std::string> errors;          // "file:line:column: text"
  std::vector<std::string> notes;           // columns that were not used
  std::vector<PlacedText> placed_errors{};  // the errors with their places
};

/// Name of the column of words in a table of a motion.
inline constexpr const char* hold_column = "hold";

/// Parses the table of a motion. The trace of a run becomes the table of a motion of this scene.
/// file: name in messages.
CsvResult parse_motion_table(std::string_view csv, const std::string& file, const SceneConfig& scene);

}  // namespace godobject
