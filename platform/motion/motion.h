// What the hand does: the target of every driven body, or the wrench on it, and whether it holds the device,
// as functions of time.
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

/// What the user does besides moving: lets go and takes hold again, opens and closes the clutch.
struct MotionSwitches {
  bool engaged = true;
  bool clutch = true;  // relative devices
};

/// What the script wants a device to hold that takes hold of bodies.
struct HoldWish {
  enum class Kind : std::uint8_t { nothing, body, nearest };
  Kind kind = Kind::nothing;
  std::size_t body = 0;  // index in the scene

  friend bool operator==(const HoldWish&, const HoldWish&) = default;
};

/// The wish for the body of this name; HoldConfig says which names there are.
HoldWish hold_wish(const SceneConfig& scene, const std::string& name);

struct MotionResult;

/// Bodies are counted as motion_targets() of the scene lists them: where the device takes hold of bodies
/// there is one, the device itself. Evaluation does not allocate.
class Motion {
 public:
  /// The scene's own [motion]: of the device's joints, each handle moving its body, or of the first driven
  /// body. Other bodies rest at their start, and so does the first where the scene has no [motion].
  explicit Motion(const SceneConfig& scene);

  /// From a table with columns t (s, strictly increasing) and, for every driven body,
  ///   <body>.x, y, z, qw, qx, qy, qz   (m; unit quaternion), or
  ///   <body>.fx, fy, fz, tx, ty, tz    (N, N m; admittance devices), or
  ///   <joint> for every joint of the device (rad or m): each handle moves its body, other bodies rest;
  /// and, for any of them, <body>.engaged, <body>.clutch (0 or 1). Where the device takes hold of bodies its
  /// name stands for <body>; instead of <body>.engaged there are hold (a name of HoldConfig; "-": nothing)
  /// and button (0 or 1). A table with no other columns than these leaves the target, or the wrench, to the
  /// scene's own [motion]; one without hold leaves that to it.
  /// Between samples: platform/motion/curve.h. Before the first and after the last: the end's pose at rest, its wrench.
  /// Switches hold from their sample to the next one; before the first sample they are as in it.
  /// A trace of a run of this scene is such a table, too: see from_trace.h.
  static MotionResult read(const std::string& path, const SceneConfig& scene);
  /// As read for a text; file is what messages call it.
  static MotionResult parse(std::string_view csv, const std::string& file, const SceneConfig& scene);

  std::size_t num_bodies() const noexcept { return starts_.size(); }
  Target target(std::size_t body, double t) const noexcept;
  /// The hand's wrench on an admittance device's body, world axes about the body's origin.
  Wrench wrench(std::size_t body, double t) const noexcept;
  /// True for a motion of the device's joints; then joints() has them and target(i, t) is the pose of the
  /// handle of body i.
  bool has_joints() const noexcept { return !joints_.empty() || !joint_sines_.empty(); }
  JointTarget joints(double t) const noexcept;
  /// Both on where the table says nothing.
  MotionSwitches switches(std::size_t body, double t) const noexcept;
  /// Nothing where neither the table nor the scene says anything.
  HoldWish hold(double t) const noexcept;
  /// The device's button is pressed.
  bool button(double t) const noexcept;
  /// Last sample's time, where the target or the wrench is a table.
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

  std::vector<Pose> starts_;                   // per driven body
  std::optional<MotionConfig> built_in_;       // for body 0
  std::vector<CoordinateMotion> joint_sines_;  // of the scene, one per joint of the device
  std::optional<KinematicTree> tree_;
  std::vector<std::optional<std::size_t>> handles_;  // per driven body: its handle
  std::optional<TimeGrid> grid_;                     // of a table, which fills one of:
  std::vector<PoseCurve> poses_;
  std::vector<WrenchCurve> wrenches_;
  std::vector<VectorCurve<double>> joints_;
  std::optional<TimeGrid> switch_grid_;                // of a table with switches
  std::vector<std::vector<MotionSwitches>> switches_;  // per driven body, one per time of switch_grid_
  std::vector<bool> buttons_;                          // one per time of switch_grid_, or none
  std::optional<TimeGrid> hold_grid_;
  std::vector<HoldWish> holds_;  // one per time of hold_grid_
};

/// The largest speed of any target, and when.
struct MotionSpeed {
  std::size_t body = 0;
  double speed = 0, t = 0;  // m/s, s
};

/// Samples the first `duration` seconds twice a step on average, at instants that no period of a motion shares.
MotionSpeed fastest(const Motion& motion, double duration, double step);

struct MotionResult {
  std::optional<Motion> motion;     // absent where there are errors
  std::vector<std::string> errors;  // "file:line:column: what"
  std::vector<std::string> notes;   // columns that were not used
};

}  // namespace godobject
