// Motion::read: converts the columns of a table into curves. Errors name their place in the file.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iterator>

#include "platform/motion/motion.h"
#include "platform/scene/keys/hand.h"
#include "platform/scene/text/toml_reader.h"

namespace godobject {

inline constexpr double recorded_unit_tolerance = 1e-3;  // recorded quaternions are rounded to few digits
inline constexpr std::size_t max_reported = 20;
inline constexpr std::size_t max_misspelling = 3;  // letters
inline constexpr double max_value = 1e6;  // m, rad, N, N m; above it a double resolves no more than 0.1 nm
/// Smallest plausible distance of times; below it rates between samples would be implausible.
inline constexpr double least_spacing_s = 1e-6, max_time_s = 1e9;
inline constexpr const char* button_column = "button";
inline constexpr const char* hold_nothing = "-";

class MotionReader {
 public:
  MotionReader(const CsvTable& table, const std::string& file, const SceneConfig& scene)
      : table_(table), log_(file), scene_(scene), motion_(scene), bodies_(motion_targets(scene)) {}

  MotionResult read() {
    check_times();
    const Content content = what_it_drives();
    const std::vector<std::string> used = columns_of(content);
    check_columns(used, content == Content::poses ? joint_columns() : std::vector<std::string>{});
    check_switches();
    check_holds();
    if (log_.ok()) check_finite(used);
    if (log_.ok()) fill(content);
    if (!log_.ok()) return {std::nullopt, log_.errors(), log_.warnings(), log_.placed_errors()};
    return {std::move(motion_), {}, log_.warnings()};
  }

 private:
  /// Content of a table besides the switches; with `nothing` the scene's own [motion] is used.
  enum class Content { nothing, poses, wrenches, joints };

  static constexpr std::array pose_suffixes{".x", ".y", ".z", ".qw", ".qx", ".qy", ".qz"};
  static constexpr std::array wrench_suffixes{".fx", ".fy", ".fz", ".tx", ".ty", ".tz"};
  static constexpr std::array switch_suffixes{".engaged", ".clutch"};
  static constexpr std::array holding_switch_suffixes{".clutch"};

  template <class Suffixes>
  std::vector<std::string> columns_of_bodies(const Suffixes& suffixes) const {
    std::vector<std::string> columns;
    for (const std::string& body : bodies_) {
      for (const char* suffix : suffixes) columns.push_back(body + suffix);
    }
    return columns;
  }
  std::vector<std::string> pose_columns() const { return columns_of_bodies(pose_suffixes); }
  std::vector<std::string> wrench_columns() const { return columns_of_bodies(wrench_suffixes); }
  std::vector<std::string> switch_columns() const {
    if (!grips_bodies(scene_)) return columns_of_bodies(switch_suffixes);
    std::vector<std::string> columns = columns_of_bodies(holding_switch_suffixes);
    columns.emplace_back(button_column);
    return columns;
  }
  /// Returns the columns that do not replace the scene's [motion].
  std::vector<std::string> columns_besides() const {
    std::vector<std::string> columns = switch_columns();
    columns.emplace_back(hold_column);
    return columns;
  }
  std::vector<std::string> joint_columns() const {
    std::vector<std::string> columns;
    if (const KinematicTreeParams* const tree = device_tree(scene_))
      for (const DeviceJoint& joint : tree->joints) columns.push_back(joint.name);
    return columns;
  }
  std::vector<std::string> columns_of(Content content) const {
    switch (content) {
      case Content::nothing: return {};
      case Content::poses: return pose_columns();
      case Content::wrenches: return wrench_columns();
      case Content::joints: return joint_columns();
    }
    return {};
  }

  bool is_position(const std::string& column) const {
    const auto has_suffix = [&](const char* suffix) { return column.ends_with(suffix); };
    return std::ranges::any_of(std::array{".x", ".y", ".z"}, has_suffix);
  }

  bool is_device(DeviceKind kind) const { return scene_.device && scene_.device->kind == kind; }

  Content what_it_drives() const {
    const Content by_device = is_device(DeviceKind::admittance) ? Content::wrenches : Content::poses;
    const std::vector<std::string> wanted = columns_of(by_device), joints = joint_columns();
    if (has_any(columns_besides()) && !has_any(wanted) && !has_any(joints)) return Content::nothing;
    if (by_device == Content::wrenches || joints.empty()) return by_device;
    const bool of_joints = missing(joints).empty() || (has_any(joints) && !has_any(wanted));
    return !missing(wanted).empty() && of_joints ? Content::joints : Content::poses;
  }

  std::vector<std::string> missing(const std::vector<std::string>& columns) const {
    std::vector<std::string> absent;
    std::ranges::copy_if(columns, std::back_inserter(absent),
                         [&](const std::string& c) { return !table_.find(c); });
    return absent;
  }

  bool has_any(const std::vector<std::string>& columns) const {
    return missing(columns).size() < columns.size();
  }

  void check_times() {
    if (table_.columns().front() != "t") log_.error({1, 1}, "the first column must be 't', the time in s");
    if (table_.num_rows() == 0) log_.error({1, 1}, "no samples follow the header: add a row for each time");
    std::size_t num_errors = 0;
    for (std::size_t row = 0; row < table_.num_rows() && num_errors < max_reported; ++row) {
      const double t = table_.at(row, 0);
      const bool increases = row == 0 || t > table_.at(row - 1, 0);
      const bool apart = row == 0 || t - table_.at(row - 1, 0) >= least_spacing_s;
      if (std::abs(t) <= max_time_s && increases && apart) continue;
      ++num_errors;
      const char* const rule = !increases ? "strictly increasing"
                               : apart    ? "within 1e9 s"
                                          : "at least 1 us apart";
      log_.error(table_.place(row, 0), std::string("times must be finite and ") + rule);
    }
  }

  void check_columns(const std::vector<std::string>& used, const std::vector<std::string>& alternative) {
    std::vector<std::string> known = used;
    append(known, columns_besides());
    std::vector<std::string> unused;
    std::ranges::copy_if(table_.columns().begin() + 1, table_.columns().end(), std::back_inserter(unused),
                         [&](const std::string& c) { return std::ranges::find(known, c) == known.end(); });
    for (const std::string& column : missing(used)) {
      std::string other =
          alternative.empty() ? "" : "; joint columns '" + alternative.front() + "', ... are an alternative";
      if (const std::string similar = nearest(column, unused, max_misspelling); !similar.empty())
        other = ": is '" + similar + "' misspelt?";
      log_.error({1, 1}, "column '" + column + "' is missing" + other);
    }
    append(known, alternative);
    const std::vector<std::string> absent = missing(known);
    for (const std::string& column : unused) {
      const std::string meant = nearest(column, absent, max_misspelling);
      log_.warning({1, 1}, "column '" + column + "' is not used" +
                               (meant.empty() ? "" : "; the nearest known column is '" + meant + "'"));
    }
  }

  void check_switches() {
    std::size_t num_errors = 0;
    for (const std::string& name : switch_columns()) {
      const std::optional<std::size_t> column = table_.find(name);
      if (!column) continue;
      for (std::size_t row = 0; row < table_.num_rows() && num_errors < max_reported; ++row) {
        const double value = table_.at(row, *column);
        if (value == 0 || value == 1) continue;
        ++num_errors;
        log_.error(table_.place(row, *column), "'" + name + "' must be 0 or 1");
      }
      if (name.ends_with(".clutch") && !is_device(DeviceKind::relative))
        log_.warning({1, 1}, "column '" + name +
                                 "' has no effect, because only relative devices have a clutch: remove it");
    }
  }

  void check_holds() {
    if (!grips_bodies(scene_)) {
      if (table_.find(hold_column))
        log_.error(
            {1, 1},
            "column 'hold' requires a device that grips bodies: give [device] 'holds' or 'grab_radius'");
      return;
    }
    const bool has_radius = scene_.device->grab_radius.has_value();
    if (table_.find(button_column) && !has_radius)
      log_.error({1, 1},
                 "column 'button' grips the nearest body and requires a reach: give [device] 'grab_radius'");
    const std::optional<std::size_t> column = table_.find(hold_column);
    std::size_t num_errors = 0;
    for (std::size_t row = 0; column && row < table_.num_rows() && num_errors < max_reported; ++row) {
      const std::string& name = table_.word(row);
      if (name == hold_nothing || (name == nearest_body && has_radius)) continue;
      const std::string why_not = name == nearest_body
                                      ? "is \"nearest\", which requires [device] 'grab_radius': add it"
                                      : why_not_held(scene_, name);
      if (why_not.empty()) continue;
      ++num_errors;
      log_.error(table_.place(row, *column), "'hold' " + why_not + "; '-' holds nothing");
    }
  }

  void check_finite(const std::vector<std::string>& columns) {
    std::size_t num_errors = 0;
    for (const std::string& name : columns) {
      const std::size_t column = *table_.find(name);
      for (std::size_t row = 0; row < table_.num_rows() && num_errors < max_reported; ++row) {
        const double value = table_.at(row, column);
        if (std::abs(value) <= max_value) continue;
        ++num_errors;
        const char* const too_far =
            is_position(name) ? "' must be within 1e6 m: give it in metres" : "' must be within 1e6";
        log_.error(table_.place(row, column),
                   "'" + name + (std::isfinite(value) ? too_far : "' must be finite"));
      }
    }
  }

  void fill(Content content) {
    const TimeGrid grid(numbers(table_.columns().front()));
    if (content != Content::nothing) {
      motion_.built_in_.reset();
      motion_.joint_sines_.clear();
      motion_.grid_ = grid;
    }
    if (content == Content::poses) fill_poses();
    if (content == Content::wrenches) fill_wrenches();
    if (content == Content::joints) fill_joints();
    if (has_any(switch_columns())) {
      motion_.switch_grid_ = grid;
      fill_switches();
    }
    if (table_.find(hold_column)) {
      motion_.hold_grid_ = grid;
      motion_.holds_.clear();
      for (std::size_t row = 0; row < table_.num_rows(); ++row)
        motion_.holds_.push_back(hold_wish(scene_, table_.word(row) == hold_nothing ? "" : table_.word(row)));
    }
  }

  std::vector<double> numbers(const std::string& column) const {
    std::vector<double> values;
    const std::size_t c = *table_.find(column);
    for (std::size_t row = 0; row < table_.num_rows(); ++row) values.push_back(table_.at(row, c));
    return values;
  }

  VectorCurve<Vec3> vectors(const std::string& x, const std::string& y, const std::string& z) const {
    const std::array columns{*table_.find(x), *table_.find(y), *table_.find(z)};
    std::vector<Vec3> values;
    for (std::size_t row = 0; row < table_.num_rows(); ++row) {
      values.emplace_back(table_.at(row, columns[0]), table_.at(row, columns[1]), table_.at(row, columns[2]));
    }
    return VectorCurve<Vec3>(*motion_.grid_, std::move(values));
  }

  std::vector<Quat> attitudes(const std::string& body) {
    const std::array c{*table_.find(body + ".qw"), *table_.find(body + ".qx"), *table_.find(body + ".qy"),
                       *table_.find(body + ".qz")};
    std::vector<Quat> values;
    std::size_t num_errors = 0;
    for (std::size_t row = 0; row < table_.num_rows() && num_errors < max_reported; ++row) {
      const Quat q(table_.at(row, c[0]), table_.at(row, c[1]), table_.at(row, c[2]), table_.at(row, c[3]));
      if (!(std::abs(q.norm() - 1) <= recorded_unit_tolerance)) {
        ++num_errors;
        log_.error(
            table_.place(row, c[0]),
            "'" + body + ".qw' to 'qz' must be a unit quaternion; its norm is " + std::to_string(q.norm()));
      }
      values.emplace_back(q.normalized());
    }
    return values;
  }

  /// column: column of the note's place.
  template <class Distance>
  void note_sudden_move(const std::string& column, const std::string& what, const char* unit,
                        double least_speed, Distance distance) {
    const std::optional<SuddenMove> move = sudden_move(*motion_.grid_, least_speed, distance);
    if (!move) return;
    std::array<char, 200> text{};
    std::snprintf(text.data(), text.size(),
                  " moves by %.3g %s in %.3g s, more than 10 times as fast as before and after: check for a "
                  "wrong or missing sample",
                  move->distance, unit, move->time);
    log_.warning(table_.place(move->from + 1, *table_.find(column)), "'" + what + "'" + text.data());
  }

  void fill_poses() {
    for (const std::string& body : bodies_) {
      std::vector<Quat> q = attitudes(body);
      if (!log_.ok()) return;
      const std::array p{numbers(body + ".x"), numbers(body + ".y"), numbers(body + ".z")};
      note_sudden_move(body + ".x", body, "m", 1, [&](std::size_t i) {
        return std::hypot(p[0][i + 1] - p[0][i], p[1][i + 1] - p[1][i], p[2][i + 1] - p[2][i]);
      });
      note_sudden_move(body + ".qw", body, "rad", 10,
                       [&](std::size_t i) { return q[i].angularDistance(q[i + 1]); });
      motion_.poses_.push_back(
          {vectors(body + ".x", body + ".y", body + ".z"), RotationCurve(*motion_.grid_, std::move(q))});
    }
  }
  void fill_wrenches() {
    for (const std::string& body : bodies_) {
      motion_.wrenches_.push_back({vectors(body + ".fx", body + ".fy", body + ".fz"),
                                   vectors(body + ".tx", body + ".ty", body + ".tz")});
    }
  }
  void fill_joints() {
    for (const DeviceJoint& joint : device_tree(scene_)->joints) {
      const std::vector<double> q = numbers(joint.name);
      const bool turns = joint.kind == DeviceJointKind::hinge;
      note_sudden_move(joint.name, joint.name, turns ? "rad" : "m", turns ? 10 : 1,
                       [&](std::size_t i) { return std::abs(q[i + 1] - q[i]); });
      motion_.joints_.emplace_back(*motion_.grid_, q);
    }
  }

  void fill_switches() {
    for (const std::string& body : bodies_) {
      const std::optional<std::size_t> engaged = table_.find(body + ".engaged");
      const std::optional<std::size_t> clutch = table_.find(body + ".clutch");
      std::vector<MotionSwitches>& values = motion_.switches_.emplace_back(table_.num_rows());
      for (std::size_t row = 0; row < values.size(); ++row) {
        if (engaged) values[row].engaged = table_.at(row, *engaged) == 1;
        if (clutch) values[row].clutch = table_.at(row, *clutch) == 1;
      }
    }
    if (grips_bodies(scene_) && table_.find(button_column))
      for (const double value : numbers(button_column)) motion_.buttons_.push_back(value == 1);
  }

  const CsvTable& table_;
  Diagnostics log_;
  const SceneConfig& scene_;
  Motion motion_;
  std::vector<std::string> bodies_;
};

MotionResult Motion::parse(std::string_view csv, const std::string& file, const SceneConfig& scene) {
  const CsvResult result = parse_motion_table(csv, file, scene);
  if (!result.table) return {std::nullopt, result.errors, {}, result.placed_errors};
  return MotionReader(*result.table, file, scene).read();
}

MotionResult Motion::read(const std::string& path, const SceneConfig& scene) {
  const FileText file = read_file(path, max_csv_bytes);
  if (!file.text)
    return {std::nullopt, {printable(path) + ": " + file.why_not}, {}, {{printable(path), {}, file.why_not}}};
  return parse(*file.text, path, scene);
}

}  // namespace godobject
