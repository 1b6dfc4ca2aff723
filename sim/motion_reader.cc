// Motion::read: from the columns of a table to curves, with every complaint placed in the file.
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <set>

#include "sim/motion.h"

namespace godobject {

inline constexpr double unit_tolerance = 1e-3;  // recorded quaternions are rounded to few digits
inline constexpr std::size_t max_reported = 20;

class MotionReader {
 public:
  MotionReader(const CsvTable& table, const std::string& file, const SceneConfig& scene)
      : table_(table), log_(file), scene_(scene), motion_(scene) {
    motion_.built_in_.reset();
    for (const std::size_t body : driven_bodies(scene)) bodies_.push_back(scene.bodies[body].name);
  }

  MotionResult read() {
    check_times();
    const bool admittance = scene_.device && scene_.device->kind == DeviceKind::admittance;
    const std::vector<std::string> wanted = admittance ? wrench_columns() : pose_columns();
    const std::vector<std::string> joints = admittance ? std::vector<std::string>{} : joint_columns();
    const bool use_joints = !joints.empty() && !missing(wanted).empty() && missing(joints).empty();
    const std::vector<std::string>& used = use_joints ? joints : wanted;
    check_columns(used, use_joints ? wanted : joints);
    if (log_.ok()) check_finite(used);
    if (!log_.ok()) return {std::nullopt, log_.errors(), {}};
    std::vector<double> times;
    for (std::size_t row = 0; row < table_.num_rows(); ++row) times.push_back(table_.at(row, 0));
    motion_.grid_.emplace(std::move(times));
    if (use_joints) {
      fill_joints(joints);
    } else if (admittance) {
      fill_wrenches();
    } else {
      fill_poses();
    }
    if (!log_.ok()) return {std::nullopt, log_.errors(), {}};
    return {std::move(motion_), {}, log_.warnings()};
  }

 private:
  static constexpr std::array pose_suffixes{".x", ".y", ".z", ".qw", ".qx", ".qy", ".qz"};
  static constexpr std::array wrench_suffixes{".fx", ".fy", ".fz", ".tx", ".ty", ".tz"};

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
  std::vector<std::string> joint_columns() const {
    std::vector<std::string> columns;
    if (!scene_.device || !scene_.device->rig) return columns;
    for (const ChainJoint& joint : scene_.device->rig->chain.joints) columns.push_back(joint.name);
    return columns;
  }

  std::vector<std::string> missing(const std::vector<std::string>& columns) const {
    std::vector<std::string> absent;
    std::ranges::copy_if(columns, std::back_inserter(absent),
                         [&](const std::string& c) { return !table_.find(c); });
    return absent;
  }

  void check_times() {
    if (table_.columns().front() != "t") log_.error({1, 1}, "the first column must be 't', in seconds");
    if (table_.num_rows() == 0) log_.error({1, 1}, "there are no samples below the header");
    std::size_t num_errors = 0;
    for (std::size_t row = 0; row < table_.num_rows() && num_errors < max_reported; ++row) {
      const double t = table_.at(row, 0);
      const bool increases = row == 0 || t > table_.at(row - 1, 0);
      if (std::isfinite(t) && increases) continue;
      ++num_errors;
      log_.error(table_.place(row, 0), "times must be finite and strictly increasing");
    }
  }

  void check_columns(const std::vector<std::string>& used, const std::vector<std::string>& alternative) {
    for (const std::string& column : missing(used)) {
      const std::string other =
          alternative.empty() ? "" : "; joint columns '" + alternative.front() + "', ... would do as well";
      log_.error({1, 1}, "column '" + column + "' is missing" + other);
    }
    const std::set<std::string> needed(used.begin(), used.end());
    for (std::size_t c = 1; c < table_.columns().size(); ++c) {
      if (!needed.contains(table_.columns()[c]))
        log_.warning({1, 1}, "column '" + table_.columns()[c] + "' is not used");
    }
  }

  void check_finite(const std::vector<std::string>& columns) {
    std::size_t num_errors = 0;
    for (const std::string& name : columns) {
      const std::size_t column = *table_.find(name);
      for (std::size_t row = 0; row < table_.num_rows() && num_errors < max_reported; ++row) {
        if (std::isfinite(table_.at(row, column))) continue;
        ++num_errors;
        log_.error(table_.place(row, column), "'" + name + "' must be finite");
      }
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
      if (!(std::abs(q.norm() - 1) <= unit_tolerance)) {
        ++num_errors;
        log_.error(
            table_.place(row, c[0]),
            "'" + body + ".qw' to 'qz' must be a unit quaternion; its norm is " + std::to_string(q.norm()));
      }
      values.emplace_back(q.normalized());
    }
    return values;
  }

  void fill_poses() {
    for (const std::string& body : bodies_) {
      std::vector<Quat> q = attitudes(body);
      if (!log_.ok()) return;
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
  void fill_joints(const std::vector<std::string>& joints) {
    for (const std::string& joint : joints) motion_.joints_.emplace_back(*motion_.grid_, numbers(joint));
  }

  const CsvTable& table_;
  Diagnostics log_;
  const SceneConfig& scene_;
  Motion motion_;
  std::vector<std::string> bodies_;
};

MotionResult Motion::parse(std::string_view csv, const std::string& file, const SceneConfig& scene) {
  const CsvResult result = parse_csv(csv, file);
  if (!result.table) return {std::nullopt, result.errors, {}};
  return MotionReader(*result.table, file, scene).read();
}

MotionResult Motion::read(const std::string& path, const SceneConfig& scene) {
  const CsvResult result = read_csv(path);
  if (!result.table) return {std::nullopt, result.errors, {}};
  return MotionReader(*result.table, path, scene).read();
}

}  // namespace godobject
