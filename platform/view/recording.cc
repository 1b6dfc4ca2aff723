#include "platform/view/recording.h"

#include <algorithm>
#include <cmath>

#include "platform/scene/text/csv.h"
#include "platform/session/trace.h"

namespace godobject {
namespace {

/// The columns of a row one after the other, as TraceWriter writes them.
class Row {
 public:
  Row(const CsvTable& table, std::size_t row) noexcept : table_(table), row_(row) {}

  double number() { return table_.at(row_, column_++); }
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
  std::uint32_t bits() { return static_cast<std::uint32_t>(number()); }
  void skip_to(std::size_t column) noexcept { column_ = column; }

 private:
  const CsvTable& table_;
  std::size_t row_, column_ = 0;
};

/// Where the columns of a trace are that are not one after the other.
struct Columns {
  std::optional<std::size_t> first_target, held, penetration, contacts, energy;
  std::vector<std::size_t> contact;  // of each body with a contact wrench: its first column
  std::vector<std::size_t> body;     // that body
};

Columns columns_of(const CsvTable& table, const SceneConfig& scene, const std::vector<std::size_t>& driven) {
  Columns columns{.first_target = driven.empty() ? std::nullopt : table.find(scene.bodies[driven.front()].name + ".target.x"),
                  .held = table.find("held"),
                  .penetration = table.find("penetration"),
                  .contacts = table.find("contacts"),
                  .energy = table.find("energy"),
                  .contact = {},
                  .body = {}};
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    if (const auto column = table.find(scene.bodies[i].name + ".contact.fx")) {
      columns.contact.push_back(*column);
      columns.body.push_back(i);
    }
  return columns;
}

/// What the contacts of a body do together, as one at its centre of mass.
void add_contact(std::size_t body, const Wrench& F_W, ViewSample& sample) {
  sample.record.bodies[body].contact_W = F_W;
  const double size = F_W.f.norm();
  if (!(size > 0)) return;
  sample.touching.push_back({.a = body, .p_W = sample.record.bodies[body].X_WB.p, .n_W = F_W.f / size, .F_W = F_W.f});
  sample.num_touching = sample.touching.size();
}

ViewSample sample_of(const CsvTable& table, std::size_t number, const std::vector<std::size_t>& driven,
                     std::size_t num_bodies, const Columns& columns) {
  Row row(table, number);
  ViewSample sample{.record = {}, .phase = RunPhase::running, .counters = {}, .touching = {}};
  CycleRecord& record = sample.record;
  record.cycle = number;
  record.t = row.number();
  record.bodies.resize(num_bodies);
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
    if (held >= 0) record.held = static_cast<std::size_t>(held);
    record.hand_W = row.wrench();
    record.engaged = record.held.has_value();
  }
  row.skip_to(*columns.penetration);
  record.contacts.deepest = row.number();
  if (columns.contacts) record.contacts.num_contacts = static_cast<std::size_t>(row.number());
  row.skip_to(*columns.energy);
  record.energy.total = row.number();
  record.energy.balance = row.number();
  record.fault = Fault(row.bits());
  record.limited = Limited(row.bits());
  record.rig_faults = RigFault(row.bits());
  return sample;
}

/// Rows that are shown: evenly over time, the first and the last among them.
std::vector<std::size_t> shown_rows(const CsvTable& table) {
  const std::size_t n = table.num_rows();
  const double span = table.at(n - 1, 0) - table.at(0, 0);
  const double period = std::max(1 / recorded_rate_hz, span / static_cast<double>(max_recorded - 2));
  std::vector<std::size_t> rows;
  double due = table.at(0, 0);
  constexpr double rounding = 1e-9;
  for (std::size_t i = 0; i < n; ++i) {
    if (table.at(i, 0) < due - rounding && i + 1 < n) continue;
    rows.push_back(i);
    due += period * std::max(1.0, std::ceil((table.at(i, 0) - due + rounding) / period));
  }
  return rows;
}

std::string why_not_of(const CsvTable& table, const SceneConfig& scene, const std::string& path) {
  const std::vector<std::string> expected = trace_columns(scene);
  if (table.num_rows() == 0) return path + ": the trace has no rows";
  const std::size_t common = std::min(expected.size(), table.columns().size());
  for (std::size_t i = 0; i < common; ++i)
    if (table.columns()[i] != expected[i])
      return path + ": column " + std::to_string(i + 1) + " is '" + table.columns()[i] + "', and a trace of scene '" +
             scene.name + "' has '" + expected[i] + "' there: is it of another scene? Give its file with --scene";
  if (table.columns().size() == expected.size()) return "";
  return path + ": " + std::to_string(table.columns().size()) + " columns, and a trace of scene '" + scene.name +
         "' has " + std::to_string(expected.size()) + ": is it of another scene, or version? Give the scene's file with --scene";
}

}  // namespace

Recording recording_of(const SceneConfig& scene) {
  Recording recording{.scene = scene, .samples = {}};
  ViewSample sample{.record = {}, .phase = RunPhase::off, .counters = {}, .touching = {}};
  sample.record.bodies.resize(scene.bodies.size());
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    sample.record.bodies[i].X_WB = sample.record.bodies[i].target.X_WD = scene.bodies[i].X_WB;
  recording.samples.push_back(std::move(sample));
  return recording;
}

RecordingResult read_trace(const std::string& path, const SceneConfig& scene) {
  RecordingResult result;
  CsvResult csv = read_csv(path);
  result.errors = std::move(csv.errors);
  if (!csv.table) return result;
  if (std::string why_not = why_not_of(*csv.table, scene, path); !why_not.empty()) {
    result.errors.push_back(std::move(why_not));
    return result;
  }
  const std::vector<std::size_t> driven = driven_bodies(scene);
  const Columns columns = columns_of(*csv.table, scene, driven);
  Recording recording{.scene = scene, .samples = {}};
  for (const std::size_t row : shown_rows(*csv.table))
    recording.samples.push_back(sample_of(*csv.table, row, driven, scene.bodies.size(), columns));
  result.recording = std::move(recording);
  return result;
}

const ViewSample& sample_at(const Recording& recording, std::optional<double> t) {
  if (!t) return recording.samples.back();
  return *std::ranges::min_element(recording.samples, {}, [t](const ViewSample& sample) { return std::abs(sample.record.t - *t); });
}

RecordedView::RecordedView(const Recording& recording, const ViewAbout& about)
    : scene_(scene_json(recording.scene, about)) {
  const std::vector<std::size_t> driven = driven_bodies(recording.scene);
  auto frames = std::make_shared<std::vector<std::uint8_t>>();
  std::vector<std::uint8_t> frame;
  for (const ViewSample& sample : recording.samples) {
    encode(sample, driven, {}, frame);
    frames->insert(frames->end(), frame.begin(), frame.end());
  }
  frames_ = std::move(frames);
}

}  // namespace godobject
