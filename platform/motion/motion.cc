#include "platform/motion/motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/math/so3.h"

namespace godobject {
namespace {

/// Evaluates A sin(2 pi f t + phase) per component, and its derivative.
Sample<Vec3> sines(const Vec3& amplitude, const Vec3& frequency_hz, const Vec3& phase, double t) noexcept {
  Sample<Vec3> sample{Vec3::Zero(), Vec3::Zero()};
  for (int i = 0; i < 3; ++i) {
    const double omega = 2 * std::numbers::pi * frequency_hz[i];
    sample.value[i] = amplitude[i] * std::sin(omega * t + phase[i]);
    sample.rate[i] = amplitude[i] * omega * std::cos(omega * t + phase[i]);
  }
  return sample;
}

Sample<double> sine(const CoordinateMotion& m, double t) noexcept {
  const double omega = 2 * std::numbers::pi * m.frequency_hz, angle = omega * t + m.phase;
  return {m.offset + m.amplitude * std::sin(angle), m.amplitude * omega * std::cos(angle)};
}

Quat turn(const Vec3& axis, double angle) noexcept { return Quat(Eigen::AngleAxis<Real>(angle, axis)); }

Target evaluate(const MotionConfig& m, double t) noexcept {
  const Sample<Vec3> p = sines(m.amplitude, m.frequency_hz, m.phase, t);
  const Sample<Vec3> angles = sines(m.angle_amplitude, m.angle_frequency_hz, m.angle_phase, t);
  // q = q_0 qz qy qx;  w_W = q_0 (z a_z' + qz (y a_y' + qy x a_x'))
  const Quat q_z = m.X_WD.q * turn(Vec3::UnitZ(), angles.value[0]);
  const Quat q_zy = q_z * turn(Vec3::UnitY(), angles.value[1]);
  const Quat q = q_zy * turn(Vec3::UnitX(), angles.value[2]);
  const Vec3 w = to_world(m.X_WD.q, Vec3::UnitZ()) * angles.rate[0] +
                 to_world(q_z, Vec3::UnitY()) * angles.rate[1] +
                 to_world(q_zy, Vec3::UnitX()) * angles.rate[2];
  return {{m.X_WD.p + p.value, q.normalized()}, {w, p.rate}};
}

constexpr std::array pose_suffixes{".x", ".y", ".z", ".qw", ".qx", ".qy", ".qz"};
constexpr std::array wrench_suffixes{".fx", ".fy", ".fz", ".tx", ".ty", ".tz"};

/// Columns of the trace with their names in a motion.
class Columns {
 public:
  explicit Columns(const CsvTable& table) : table_(table) {}

  /// Adds the columns of a group. Returns false, and adds nothing, if one is missing.
  template <class Suffixes>
  bool add_all(const std::vector<std::string>& targets, const std::string& group, const Suffixes& suffixes) {
    std::vector<CsvColumn> found;
    for (const std::string& target : targets)
      for (const char* suffix : suffixes) {
        const std::optional<std::size_t> column = table_.find(target + group + suffix);
        if (!column) return false;
        found.push_back({.from = *column, .name = target + suffix});
      }
    columns.insert(columns.end(), found.begin(), found.end());
    return true;
  }
  /// Adds the columns of the joints. Returns false, and adds nothing, if one is missing or has no number in
  /// any row.
  bool add_joints(const std::vector<DeviceJoint>& joints) {
    std::vector<CsvColumn> found;
    for (const DeviceJoint& joint : joints) {
      const std::optional<std::size_t> column = table_.find("device." + joint.name + ".q");
      if (!column || !has_numbers(*column)) return false;
      found.push_back({.from = *column, .name = joint.name});
    }
    columns.insert(columns.end(), found.begin(), found.end());
    return !found.empty();
  }
  void add(const std::string& column, const std::string& name,
           std::function<std::string(double)> word = nullptr) {
    if (const auto found = table_.find(column))
      columns.push_back({.from = *found, .name = name, .word = std::move(word)});
  }

  std::vector<CsvColumn> columns;

 private:
  bool has_numbers(std::size_t column) const {
    for (std::size_t row = 0; row < table_.num_rows(); ++row)
      if (std::isfinite(table_.at(row, column))) return true;
    return false;
  }

  const CsvTable& table_;
};

/// True for a table with the header of a trace.
bool is_trace(std::string_view csv) {
  const std::string_view header = csv.substr(0, csv.find_first_of("\r\n"));
  return header.starts_with("t,") &&
         header.find(",energy,energy_balance,fault,limited,rig_fault") != header.npos;
}

/// Returns the complete lines of a trace; the last line of a killed run has no end.
std::string_view whole_lines(std::string_view csv) {
  const std::size_t end = csv.rfind('\n');
  return end == csv.npos ? csv : csv.substr(0, end + 1);
}

/// True for the columns of a trace that a motion can use.
bool is_of_motion(std::string_view column) {
  constexpr std::array groups{".target.", ".device.", ".hand.", ".engaged", ".clutch"};
  return column == "t" || column == "held" || column.starts_with("device.") ||
         std::ranges::any_of(groups, [&](const char* group) { return column.find(group) != column.npos; });
}

/// Returns the table of a motion of this scene. Uses the rows with the device's joints if there are any, else
/// the hand's wrenches or the device's poses, else the targets. Adds engaged, clutch and held.
/// table: table of the trace.
CsvResult motion_of_trace(const CsvTable& table, const std::string& file, const SceneConfig& scene) {
  const std::vector<std::string> targets = motion_targets(scene);
  const bool by_wrenches = scene.device && scene.device->kind == DeviceKind::admittance;
  Columns columns(table);
  columns.add("t", "t");
  const bool complete = by_wrenches ? columns.add_all(targets, ".hand", wrench_suffixes)
                                    : (scene.device && scene.device->rig &&
                                       columns.add_joints(scene.device->rig->tree.joints)) ||
                                          columns.add_all(targets, ".device", pose_suffixes) ||
                                          columns.add_all(targets, ".target", pose_suffixes);
  if (!complete) {
    const std::string wanted =
        targets.empty() ? "" : targets.front() + (by_wrenches ? ".hand.fx" : ".target.x");
    const std::string why = "the trace has no column '" + wanted + "', which scene '" + scene.name +
                            "' requires: give the trace of this scene";
    return {std::nullopt, {format_diagnostic(file, {1, 1}, why)}, {{file, TextPosition{1, 1}, why}}};
  }
  for (const std::string& target : targets) {
    if (!grips_bodies(scene)) columns.add(target + ".engaged", target + ".engaged");
    if (scene.device && scene.device->kind == DeviceKind::relative)
      columns.add(target + ".clutch", target + ".clutch");
  }
  if (grips_bodies(scene))
    columns.add("held", hold_column, [&](double held) {
      const bool is_body = held >= 0 && held < static_cast<double>(scene.bodies.size());
      return is_body ? scene.bodies[static_cast<std::size_t>(held)].name : std::string("-");
    });
  return {table.selected(columns.columns), {}};
}

}  // namespace

// ---- motions --------------------------------------------------------------------------------------

HoldWish hold_wish(const SceneConfig& scene, const std::string& name) {
  if (name.empty()) return {};
  if (name == nearest_body) return {.kind = HoldWish::Kind::nearest};
  return {.kind = HoldWish::Kind::body, .body = body_named(scene, name).value()};
}

Motion::Motion(const SceneConfig& scene) : built_in_(scene.motion) {
  for (const std::size_t body : driven_bodies(scene)) starts_.push_back(scene.bodies[body].X_WB);
  starts_.resize(motion_targets(scene).size());
  handles_.resize(starts_.size());
  if (grips_bodies(scene)) take_holds(scene);
  const KinematicTreeParams* const tree = device_tree(scene);
  if (tree == nullptr) return;
  tree_.emplace(*tree);
  const std::vector<std::optional<std::size_t>> by_handle = driven_by_handles(scene);
  for (std::size_t handle = 0; handle < tree_->num_handles(); ++handle)
    if (by_handle[handle]) handles_[*by_handle[handle]] = handle;
  if (!built_in_ || built_in_->joints.empty()) return;
  for (std::size_t joint = 0; joint < tree_->num_joints(); ++joint) {
    const std::string& name = tree->joints[joint].name;
    const auto moved = std::ranges::find(built_in_->joints, name, &CoordinateMotion::coordinate);
    joint_sines_.push_back(moved == built_in_->joints.end() ? CoordinateMotion{} : *moved);
  }
}

/// Merges the body held at the start and the scene's [[motion.hold]].
void Motion::take_holds(const SceneConfig& scene) {
  std::vector<HoldConfig> holds;
  if (built_in_) holds = built_in_->holds;
  if (holds.empty() || holds.front().time > 0)
    holds.insert(holds.begin(), {.time = 0, .body = scene.device->holds});
  std::vector<double> times;
  for (const HoldConfig& hold : holds) {
    times.push_back(hold.time);
    holds_.push_back(hold_wish(scene, hold.body));
  }
  hold_grid_.emplace(std::move(times));
}

Target Motion::target(std::size_t body, double t) const noexcept {
  if (!poses_.empty()) {
    const TimeGrid::Place place = grid_->locate(t);
    const Sample<Vec3> p = poses_[body].p.at(place);
    const RotationCurve::Attitude q = poses_[body].q.at(place);
    return {{p.value, q.q}, {q.w_W, p.rate}};
  }
  if (has_joints() && handles_[body]) {
    const JointTarget sample = joints(t);
    const TreeConfiguration device = tree_->at(sample.q);
    return {device.X_WH(*handles_[body]), device.twist(*handles_[body], sample.q_dot)};
  }
  if (body == 0 && built_in_) return evaluate(*built_in_, t);
  return {starts_[body], {}};
}

Wrench Motion::wrench(std::size_t body, double t) const noexcept {
  if (!wrenches_.empty()) {
    const TimeGrid::Place place = grid_->locate(t);
    return {wrenches_[body].tau.at(place).value, wrenches_[body].f.at(place).value};
  }
  if (body != 0 || !built_in_) return {};
  const MotionConfig& m = *built_in_;
  return {sines(m.torque_amplitude, m.frequency_hz, m.phase, t).value,
          sines(m.force_amplitude, m.frequency_hz, m.phase, t).value};
}

JointTarget Motion::joints(double t) const noexcept {
  const std::size_t n = std::max(joints_.size(), joint_sines_.size());
  JointTarget target{JointVector::Zero(static_cast<Eigen::Index>(n)),
                     JointVector::Zero(static_cast<Eigen::Index>(n))};
  const TimeGrid::Place place = joints_.empty() ? TimeGrid::Place{} : grid_->locate(t);
  for (std::size_t i = 0; i < n; ++i) {
    const Sample<double> joint = joints_.empty() ? sine(joint_sines_[i], t) : joints_[i].at(place);
    target.q[static_cast<Eigen::Index>(i)] = joint.value;
    target.q_dot[static_cast<Eigen::Index>(i)] = joint.rate;
  }
  return target;
}

MotionSwitches Motion::switches(std::size_t body, double t) const noexcept {
  if (!switch_grid_) return {};
  return switches_[body][switch_grid_->held(t)];
}

HoldWish Motion::hold(double t) const noexcept {
  return hold_grid_ ? holds_[hold_grid_->held(t)] : HoldWish{};
}

bool Motion::button(double t) const noexcept { return !buttons_.empty() && buttons_[switch_grid_->held(t)]; }

std::optional<double> Motion::end() const noexcept {
  if (!grid_) return std::nullopt;
  return grid_->last();
}

MotionSpeed fastest(const Motion& motion, double duration, double step) {
  constexpr double golden =
      0.6180339887498949;  // multiples modulo 1 are evenly spread for any number of them
  const int num_samples = static_cast<int>(std::clamp(2 * duration / step, 2e3, 2e5));
  MotionSpeed found;
  for (std::size_t body = 0; body < motion.num_bodies(); ++body)
    for (int i = 0; i < num_samples; ++i) {
      const double t = duration * std::fmod(golden * i, 1.0);
      const double speed = motion.target(body, t).V_WD.v.norm();
      if (speed > found.speed) found = {.body = body, .speed = speed, .t = t};
    }
  return found;
}

// ---- tables ---------------------------------------------------------------------------------------

CsvResult parse_motion_table(std::string_view csv, const std::string& file, const SceneConfig& scene) {
  if (!is_trace(csv)) return parse_csv(csv, file, hold_column);
  const CsvResult trace = parse_csv(whole_lines(csv), file, "", is_of_motion);
  return trace.table ? motion_of_trace(*trace.table, file, scene) : trace;
}

}  // namespace godobject
