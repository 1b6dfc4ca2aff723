#include "platform/view/recorded/recording.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <span>
#include <string_view>

#include "platform/trace/trace.h"
#include "platform/view/drawing.h"

namespace godobject {
namespace {

/// Reads the numbers of a row in the order in which TraceWriter writes them.
class Row {
 public:
  explicit Row(std::span<const double> numbers) noexcept : numbers_(numbers) {}

  double number() { return numbers_[column_++]; }
  Vec3 vector() {
    const double x = number(), y = number(), z = number();
    return {x, y, z};
  }
  Pose pose() {
    Pose X{.p = vector()};
    const double w = number();
    const Vec3 v = vector();
    X.q = Quat(w, v.x(), v.y(), v.z());
    return X;
  }
  Wrench wrench() {
    const Vec3 f = vector();
    return {.tau = vector(), .f = f};
  }
  std::uint32_t bits() { return saturate_to<std::uint32_t>(number()); }
  void skip_to(std::size_t column) noexcept { column_ = column; }

 private:
  std::span<const double> numbers_;
  std::size_t column_ = 0;
};

/// Columns of a trace that depend on the scene.
struct Columns {
  std::optional<std::size_t> first_target, held, penetration, contacts, energy;
  std::vector<std::size_t> contact;  // first column of each body's contact wrench
  std::vector<std::size_t> body;     // body of that wrench
  // first columns of the wrenches of joints and terms, of coordinates and of commands; absent in old traces
  std::optional<std::size_t> wrenches, joint_q, device_q, drives;
};

Columns columns_of(const std::vector<std::string>& names, const SceneConfig& scene,
                   const std::vector<std::size_t>& driven) {
  const auto find = [&](const std::string& name) -> std::optional<std::size_t> {
    const auto found = std::ranges::find(names, name);
    return found == names.end() ? std::nullopt
                                : std::optional(static_cast<std::size_t>(found - names.begin()));
  };
  Columns columns{
      .first_target = driven.empty() ? std::nullopt : find(scene.bodies[driven.front()].name + ".target.x"),
      .held = find("held"),
      .penetration = find("penetration"),
      .contacts = find("contacts"),
      .energy = find("energy"),
      .contact = {},
      .body = {},
      .wrenches = {},
      .joint_q = {},
      .device_q = {},
      .drives = {}};
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    if (const auto column = find(scene.bodies[i].name + ".contact.fx")) {
      columns.contact.push_back(*column);
      columns.body.push_back(i);
    }
  const std::vector<std::string> terms = term_names(scene);
  if (!scene.joints.empty() || !terms.empty())
    columns.wrenches = find((scene.joints.empty() ? terms.front() : scene.joints.front().name) + ".fx");
  for (const JointConfig& joint : scene.joints)
    for (const char* q : {".q", ".q1"})
      if (!columns.joint_q) columns.joint_q = find(joint.name + q);
  if (!scene.device || !scene.device->rig) return columns;
  const RigParams& rig = *scene.device->rig;
  columns.device_q = find("device." + rig.tree.joints.front().name + ".q");
  if (!rig.drives.empty()) columns.drives = find("drive." + rig.drives.front().joint + ".torque");
  return columns;
}

/// Adds the sum of a body's contacts as one contact at its centre of mass.
void add_contact(std::size_t body, const Wrench& F_W, ViewSample& sample) {
  sample.record.bodies[body].contact_W = F_W;
  const double size = F_W.f.norm();
  if (!(size > 0)) return;
  sample.touching.push_back(
      {.a = body, .p_W = sample.record.bodies[body].X_WB.p, .n_W = F_W.f / size, .F_W = F_W.f});
  sample.num_touching = sample.touching.size();
}

/// Reads the numbers of joints and drives. like: record with storage for them.
void read_values(Row& row, const ViewBodies& bodies, const Columns& columns, CycleRecord& record) {
  if (columns.wrenches) {
    row.skip_to(*columns.wrenches);
    for (const std::size_t child : bodies.children) record.bodies[child].joint_C = row.wrench();
    for (Wrench& F : record.term_forces) F = row.wrench();
  }
  const auto read = [&](const std::optional<std::size_t>& first, std::vector<double>& to) {
    if (first) row.skip_to(*first);
    for (double& value : to) value = first ? row.number() : std::numeric_limits<double>::quiet_NaN();
  };
  read(columns.joint_q, record.joint_q);
  read(columns.device_q, record.device_q);
  read(columns.drives, record.drive_torque);
}

/// Returns a record with storage for all numbers of the scene.
CycleRecord blank_record(const SceneConfig& scene) {
  const TraceDeviceColumns device = device_columns(scene);
  CycleRecord record;
  record.bodies.resize(scene.bodies.size());
  record.term_forces.resize(term_names(scene).size());
  record.joint_q.resize(device.num_coordinates);
  record.device_q.resize(device.num_device_joints);
  record.drive_torque.resize(device.num_drives);
  return record;
}

/// blank: see blank_record().
ViewSample sample_of(std::span<const double> numbers, const ViewBodies& indices, const CycleRecord& blank,
                     const Columns& columns) {
  const std::vector<std::size_t>& driven = indices.driven;
  const std::size_t num_bodies = blank.bodies.size();
  Row row(numbers);
  ViewSample sample{.record = blank, .phase = RunPhase::running, .counters = {}, .touching = {}};
  CycleRecord& record = sample.record;
  record.t = row.number();
  for (BodyView& body : record.bodies) {
    body.X_WB = row.pose();
    body.V_WB.v = row.vector();
    body.V_WB.w = row.vector();
  }
  for (const std::size_t i : driven) {
    record.bodies[i].coupling_B = row.wrench();
    record.bodies[i].feedback_D = row.wrench();
  }
  if (columns.first_target) row.skip_to(*columns.first_target);
  for (const std::size_t i : driven) record.bodies[i].target.X_WD = row.pose();
  for (std::size_t i = 0; i < columns.contact.size(); ++i) {
    row.skip_to(columns.contact[i]);
    add_contact(columns.body[i], row.wrench(), sample);
  }
  record.engaged = !driven.empty();
  if (columns.held) {
    row.skip_to(*columns.held);
    const double held = row.number();
    if (held >= 0 && held < static_cast<double>(num_bodies)) record.held = static_cast<std::size_t>(held);
    record.hand_W = row.wrench();
    record.engaged = record.held.has_value();
  }
  row.skip_to(*columns.penetration);
  record.contacts.deepest = row.number();
  if (columns.contacts) record.contacts.num_contacts = row.bits();
  row.skip_to(*columns.energy);
  record.energy.total = row.number();
  record.energy.balance = row.number();
  record.fault = Fault(row.bits());
  record.limited = Limited(row.bits());
  record.rig_faults = RigFault(row.bits());
  read_values(row, indices, columns, record);
  return sample;
}

std::string why_not_trace(const std::vector<std::string>& names, const SceneConfig& scene,
                          const std::string& path) {
  const std::vector<std::string> expected = trace_columns(scene);
  const std::size_t common = std::min(expected.size(), names.size());
  for (std::size_t i = 0; i < common; ++i)
    if (names[i] != expected[i])
      return path + ":1: column " + std::to_string(i + 1) + " is '" + names[i].substr(0, 64) +
             "', and a trace of scene '" + scene.name + "' has '" + expected[i] +
             "' there: is it of another scene? Give its file with --scene";
  // Traces of earlier versions end before the devices' columns, which are not displayed.
  const bool has_shown = std::ranges::find(names, "rig_fault") != names.end();
  if (names.size() == expected.size() || (names.size() < expected.size() && has_shown)) return "";
  return path + ":1: " + std::to_string(names.size()) + " columns, and a trace of scene '" + scene.name +
         "' has " + std::to_string(expected.size()) +
         ": is it of another scene, or version? Give the scene's file with --scene";
}

/// Stores the displayed rows of a trace, at most max_recorded.
class TraceReader {
 public:
  TraceReader(const SceneConfig& scene, const std::vector<std::string>& names)
      : blank_(blank_record(scene)),
        indices_(scene),
        columns_(columns_of(names, scene, indices_.driven)),
        numbers_(names.size()) {}

  /// Returns false if the line is no row of the trace.
  bool add(const std::string& line) {
    double t = 0;
    const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), t);
    if (error != std::errc() || !std::isfinite(t)) return false;
    constexpr double rounding = 1e-9;
    if (!samples.empty() && t < due_ - rounding) return true;
    if (!read_numbers(line, numbers_)) return false;
    samples.push_back(sample_of(numbers_, indices_, blank_, columns_));
    due_ = t + period_;
    if (samples.size() == max_recorded) thin_out();
    return true;
  }

  std::vector<ViewSample> samples;

 private:
  /// Drops every other sample and doubles the period of the following ones.
  void thin_out() {
    for (std::size_t i = 0; 2 * i < samples.size(); ++i) samples[i] = samples[2 * i];
    samples.resize((samples.size() + 1) / 2);
    period_ *= 2;
  }

  CycleRecord blank_;
  ViewBodies indices_;
  Columns columns_;
  std::vector<double> numbers_;
  double due_ = 0, period_ = 1 / recorded_rate_hz;
};

}  // namespace

Recording recording_of(const SceneConfig& scene) {
  Recording recording{.scene = scene, .samples = {}};
  ViewSample sample{.record = blank_record(scene), .phase = RunPhase::off, .counters = {}, .touching = {}};
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    sample.record.bodies[i].X_WB = sample.record.bodies[i].target.X_WD = scene.bodies[i].X_WB;
  recording.samples.push_back(std::move(sample));
  return recording;
}

RecordingResult read_trace(const std::string& path, const SceneConfig& scene) {
  std::optional<TraceReader> reader;
  std::size_t num_columns = 0;
  std::string wrong = read_rows(
      path,
      [&](const std::vector<std::string>& names) {
        num_columns = names.size();
        std::string why_not = why_not_trace(names, scene, path);
        if (why_not.empty()) reader.emplace(scene, names);
        return why_not;
      },
      [&](const std::string& row) {
        return reader->add(row) ? std::string()
                                : "not the " + std::to_string(num_columns) + " numbers of a trace's row";
      });
  if (wrong.empty() && reader->samples.empty()) wrong = path + ": the trace has no rows";
  RecordingResult result;
  if (!wrong.empty()) result.errors.push_back(std::move(wrong));
  else result.recording = Recording{.scene = scene, .samples = std::move(reader->samples)};
  return result;
}

const ViewSample& sample_at(const Recording& recording, std::optional<double> t) {
  if (!t) return recording.samples.back();
  return *std::ranges::min_element(recording.samples, {},
                                   [t](const ViewSample& sample) { return std::abs(sample.record.t - *t); });
}

std::vector<Vec3> nodes_of(const Recording& recording, const SceneNets& nets, const ViewSample& sample) {
  if (sample.net_nodes.empty() && recording.nets) return recording.nets->at(sample.record.t);
  return nodes_of(nets, sample);
}

RecordedView::RecordedView(const Recording& recording, const ViewAbout& about)
    : scene_(scene_json(recording.scene, about)) {
  const ViewBodies bodies(recording.scene);
  auto frames = std::make_shared<std::vector<std::uint8_t>>();
  std::vector<std::uint8_t> frame;
  const SceneNets nets = scene_nets(recording.scene);
  const std::size_t bytes_of_nodes = recording.samples.size() * nets.nodes.size() * frame_vertex_bytes;
  const std::size_t stride = 1 + bytes_of_nodes / max_recorded_net_bytes;
  for (std::size_t i = 0; i < recording.samples.size(); i += stride) {
    const ViewSample& sample = recording.samples[i];
    encode(sample, bodies.driven, nodes_of(recording, nets, sample), frame, bodies.children);
    frames->insert(frames->end(), frame.begin(), frame.end());
  }
  frames_ = std::move(frames);
}

}  // namespace godobject
