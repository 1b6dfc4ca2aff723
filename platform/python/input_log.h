// Input logs (.godo) as arrays: columns with the names of traces, and the inputs of the core.
#pragma once

#include <pybind11/pybind11.h>

#include <array>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "platform/python/errors.h"
#include "platform/python/quantities.h"
#include "platform/scene/joint/joints.h"
#include "platform/simulated/session.h"
#include "platform/trace/input_log.h"
#include "platform/trace/trace.h"

namespace godobject {

/// Columns of an input log. An index of `of` is a body, a joint or a drive.
class InputLogColumns {
 public:
  InputLogColumns(const SceneConfig& scene, std::int64_t log_origin_ns) : scene_(scene) {
    add("t", [](const CycleRecord& r) { return r.t; });
    add("t_bus", [log_origin_ns](const CycleRecord& r) {
      return r.t_bus_ns == 0 ? 0 : 1e-9 * static_cast<double>(r.t_bus_ns + log_origin_ns);
    });
    add_states();
    add_inputs();
    add_devices();
  }

  const std::vector<std::string>& names() const { return names_; }
  void write(const CycleRecord& record, Numbers& to) const {
    for (const Column& column : columns_) to.push_back(column(record));
  }

 private:
  using Column = std::function<double(const CycleRecord&)>;
  static constexpr std::array twist_columns{"vx", "vy", "vz", "wx", "wy", "wz"};

  void add(const std::string& name, Column column) {
    names_.push_back(name);
    columns_.push_back(std::move(column));
  }
  /// Adds the numbers of a pose, twist or wrench. of: returns it.
  template <std::size_t n, class Of>
  void add(const std::string& prefix, const std::array<const char*, n>& suffixes, Of of) {
    for (std::size_t i = 0; i < n; ++i)
      add(prefix + suffixes[i], [of, i](const CycleRecord& r) {
        std::array<double, n> numbers{};
        godobject::write(of(r), numbers.data());
        return numbers[i];
      });
  }

  void add_states() {
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      const std::string name = scene_.bodies[i].name + ".";
      add(name, pose_columns, [i](const CycleRecord& r) { return r.bodies[i].X_WB; });
      add(name, twist_columns, [i](const CycleRecord& r) { return r.bodies[i].V_WB; });
      add(name + "coupling.", wrench_columns, [i](const CycleRecord& r) { return r.bodies[i].coupling_B; });
      add(name + "feedback.", wrench_columns, [i](const CycleRecord& r) { return r.bodies[i].feedback_D; });
      add(name + "contact.", wrench_columns, [i](const CycleRecord& r) { return r.bodies[i].contact_W; });
      for (const JointConfig& joint : scene_.joints)
        if (joint.child == scene_.bodies[i].name)
          add(joint.name + ".", wrench_columns, [i](const CycleRecord& r) { return r.bodies[i].joint_C; });
    }
    add("held", [](const CycleRecord& r) { return r.held ? static_cast<double>(*r.held) : -1; });
    add("hand.", wrench_columns, [](const CycleRecord& r) { return r.hand_W; });
    add("fault", [](const CycleRecord& r) { return static_cast<double>(r.fault); });
    add("limited", [](const CycleRecord& r) { return static_cast<double>(r.limited); });
    add("rig_fault", [](const CycleRecord& r) { return static_cast<double>(r.rig_faults); });
  }

  void add_inputs() {
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      const std::string name = scene_.bodies[i].name + ".input.";
      add(name, pose_columns, [i](const CycleRecord& r) { return r.samples[i].target.X_WD; });
      add(name, twist_columns, [i](const CycleRecord& r) { return r.samples[i].target.V_WD; });
      add(name, wrench_columns, [i](const CycleRecord& r) { return r.samples[i].F_WB; });
      for (Eigen::Index k = 0; k < BodySample{}.joint.q.size(); ++k)
        add(name + "q" + std::to_string(k + 1),
            [i, k](const CycleRecord& r) { return r.samples[i].joint.q[k]; });
      add(name + "valid", [i](const CycleRecord& r) { return r.samples[i].valid ? 1 : 0; });
      add(name + "engaged", [i](const CycleRecord& r) { return r.samples[i].engaged ? 1 : 0; });
      add(name + "clutch", [i](const CycleRecord& r) { return r.samples[i].clutch ? 1 : 0; });
    }
  }

  void add_devices() {
    std::size_t q = 0;
    for (const JointConfig& joint : scene_.joints) {
      const std::size_t n = num_coordinates(joint.kind);
      for (std::size_t k = 1; k <= n; ++k, ++q)
        add(joint.name + ".q" + (n > 1 ? std::to_string(k) : ""), of_numbers(&CycleRecord::joint_q, q));
    }
    if (!scene_.device || !scene_.device->rig) return;
    const RigParams& rig = *scene_.device->rig;
    for (std::size_t i = 0; i < rig.tree.joints.size(); ++i)
      add("device." + rig.tree.joints[i].name + ".q", of_numbers(&CycleRecord::device_q, i));
    for (std::size_t i = 0; i < rig.drives.size(); ++i) {
      add("drive." + rig.drives[i].joint + ".torque", of_numbers(&CycleRecord::drive_torque, i));
      add("drive." + rig.drives[i].joint + ".generated", of_numbers(&CycleRecord::drive_energy, i));
    }
  }

  /// Returns the i-th of numbers, or 0 where a run had no such device.
  static Column of_numbers(std::vector<double> CycleRecord::*numbers, std::size_t i) {
    return [numbers, i](const CycleRecord& r) { return i < (r.*numbers).size() ? (r.*numbers)[i] : 0; };
  }

  const SceneConfig& scene_;
  std::vector<std::string> names_;
  std::vector<Column> columns_;
};

/// Reads an input log. Returns the names of its columns, an array (rows, columns) and a note on missing rows.
inline py::tuple read_input_log(const std::string& path) {
  const MappedFile file(path);
  if (!file.why_not().empty()) refuse("ReadError", path, {"cannot be read: " + file.why_not()});
  InputLogReader reader(file.bytes());
  if (!reader.why_not().empty()) refuse("ReadError", path, {reader.why_not()});
  LoadResult loaded = parse_scene_of(reader.head(), simulated_faults());
  refuse("ReadError", path, loaded.errors);
  if (loaded.scene->bodies.size() != reader.head().sizes.bodies)
    refuse("ReadError", path, {"its scene has other bodies than its rows: it is damaged"});
  const InputLogColumns columns(*loaded.scene, reader.head().log_origin_ns);
  Numbers numbers;
  std::string note;
  {
    const py::gil_scoped_release released;
    columns.write(reader.start(), numbers);
    for (auto item = reader.next(); item != InputLogReader::Item::end; item = reader.next()) {
      if (item == InputLogReader::Item::row) columns.write(reader.row(), numbers);
      if (item != InputLogReader::Item::cut) continue;
      note = "was cut, or is still written";
      break;
    }
  }
  if (reader.lost_rows() > 0)
    note = std::to_string(reader.lost_rows()) + " rows were lost while it was written";
  if (reader.damaged_bytes() > 0)
    note = std::to_string(reader.damaged_bytes()) + " damaged bytes are left out";
  const Shape shape{length(numbers.size() / columns.names().size()), length(columns.names().size())};
  return py::make_tuple(columns.names(), array_of(std::move(numbers), shape), note);
}

}  // namespace godobject
