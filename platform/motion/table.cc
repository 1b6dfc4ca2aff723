// Table of a motion: as its file has it, or converted from the trace of a run. A trace gives the devices'
// samples, not the bodies that followed them.
#include "platform/motion/motion.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace godobject {
namespace {

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
    return {std::nullopt,
            {file + ":1:1: the trace has no column '" + wanted + "', which scene '" + scene.name +
             "' requires: give the trace of this scene"}};
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

CsvResult parse_motion_table(std::string_view csv, const std::string& file, const SceneConfig& scene) {
  if (!is_trace(csv)) return parse_csv(csv, file, hold_column);
  const CsvResult trace = parse_csv(whole_lines(csv), file, "", is_of_motion);
  return trace.table ? motion_of_trace(*trace.table, file, scene) : trace;
}

}  // namespace godobject
