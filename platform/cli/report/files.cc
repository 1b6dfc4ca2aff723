#include "platform/cli/report/files.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <set>
#include <utility>

#include "platform/cli/report/revision.h"
#include "platform/scene/text/diagnostics.h"
#include "platform/scene/toml.h"
#include "platform/session/passivity.h"

namespace godobject {
namespace {

constexpr std::size_t batch = 4096;  // frames; far more than arrive in a few periods

constexpr std::chrono::milliseconds close_patience{2000};
constexpr std::size_t waiting_bytes = 16u << 20;

std::vector<std::string> bus_names(const SceneConfig& scene) {
  std::vector<std::string> names;
  if (scene.device && scene.device->rig)
    for (const BusParams& bus : scene.device->rig->buses) names.push_back(bus.name);
  return names;
}

constexpr std::size_t max_scene_file_bytes = std::size_t{256} << 20;

/// Reads the files to which the scene refers. Omits files that have become unreadable.
std::vector<InputLogFile> files_of(const SceneConfig& scene, const std::string& scene_file) {
  std::set<std::string> names;
  for (const ObstacleConfig& obstacle : scene.obstacles) names.insert(obstacle.file);
  for (const NetConfig& net : scene.nets) names.insert(net.file);
  names.erase("");
  std::vector<InputLogFile> files;
  const std::filesystem::path folder = std::filesystem::path(scene_file).parent_path();
  for (const std::string& name : names)
    if (FileText file = read_file((folder / name).string(), max_scene_file_bytes); file.text)
      files.push_back({.name = name, .bytes = std::move(*file.text)});
  return files;
}

}  // namespace

CandumpLog::CandumpLog(std::function<bool(std::string_view)> sink, std::vector<std::string> buses)
    : sink_(std::move(sink)), buses_(std::move(buses)) {
  waiting_.reserve(2 * batch);
}

void CandumpLog::add(const BusFrame& frame) {
  const std::lock_guard lock(mutex_);
  waiting_.push_back(frame);
  if (waiting_.size() == 2 * batch) write_first(batch);
}

void CandumpLog::pass_on(const std::function<void(std::string_view)>& append) {
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock.owns_lock() || waiting_.empty()) return;
  sort();
  const auto time = [](const BusFrame& f) { return f.received.t_ns; };
  const auto end = std::ranges::upper_bound(waiting_, newest_[0], {}, time);
  append(take_first(static_cast<std::size_t>(end - waiting_.begin())));
  newest_ = {newest_[1], waiting_.empty() ? newest_[1] : time(waiting_.back())};
}

bool CandumpLog::close() {
  const std::lock_guard lock(mutex_);
  write_first(waiting_.size());
  return all_written_;
}

void CandumpLog::sort() {
  std::ranges::stable_sort(waiting_, {}, [](const BusFrame& f) { return f.received.t_ns; });
}

const std::string& CandumpLog::take_first(std::size_t count) {
  buffer_.clear();
  for (std::size_t i = 0; i < count; ++i) {
    std::array<char, max_candump_line> line{};
    std::size_t length = 0;
    const CandumpResult result = format_candump(waiting_[i].received, buses_[waiting_[i].bus], line, length);
    all_written_ = all_written_ && result == CandumpResult::ok;
    buffer_.append(line.data(), length) += '\n';
  }
  waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(count));
  return buffer_;
}

void CandumpLog::write_first(std::size_t count) {
  sort();
  const std::string& text = take_first(count);
  if (!text.empty()) all_written_ = sink_(text) && all_written_;
}

// ---- input logs -----------------------------------------------------------------------------------

void list_recorded(const RunFileNames& names, Session& session) noexcept {
  if (!names.contacts.empty()) session.list_contacts();
  if (!names.nets.empty()) session.list_net_nodes();
  if (names.records_inputs()) session.list_inputs();
}

EngineState state_of(const Session& session) {
  EngineState state;
  state.bytes.resize(session.engine().snapshot_bytes());
  take_state(session, state);
  return state;
}

void take_state(const Session& session, EngineState& state) noexcept GODOBJECT_NONBLOCKING {
  session.engine().save(state.bytes);
  state.hash = session.engine().state_hash();
}

// ---- all files ------------------------------------------------------------------------------------

RunFiles::RunFiles(const RunFileNames& names, const SceneConfig& scene, Nanoseconds log_origin_ns)
    : names_(names), log_origin_ns_(log_origin_ns), driven_(driven_bodies(scene)) {
  for (const JointConfig& joint : scene.joints) children_.push_back(*body_named(scene, joint.child));
  bodies_.resize(scene.bodies.size());
  pulls_.resize(driven_.size());
  joints_.resize(children_.size() + term_names(scene).size());
  const auto into = [this](std::optional<BackgroundFile>& file, const std::string& path) {
    file.emplace(path, waiting_bytes);
    return CsvRows::Sink([this, &file](std::string_view text) { return file->write(text, patience_); });
  };
  if (names.trace_rows) trace_.emplace(names.trace_rows, scene);
  else if (!names.trace.empty()) trace_.emplace(into(trace_file_, names.trace), scene);
  if (!names.contacts.empty()) contacts_.emplace(into(contacts_file_, names.contacts), scene);
  if (!names.nets.empty()) nets_.emplace(into(nets_file_, names.nets), scene_nets(scene));
  if (names.record.empty()) return;
  record_ = std::make_shared<CandumpLog>(
      [this](std::string_view text) { return record_file_->write(text, patience_); }, bus_names(scene));
  record_file_.emplace(names.record, waiting_bytes,
                       [log = record_](const BackgroundFile::Append& append) { log->pass_on(append); });
}

void RunFiles::start(const Session& session) {
  add(session.at_start());
  if (wants_inputs()) start_inputs(session, *start_);
}

void RunFiles::start_inputs(const Session& session, const CycleRecord& start) {
  const Engine& engine = session.engine();
  InputLogHead head{.version = GODOBJECT_VERSION,
                    .scene_file = names_.scene,
                    .scene = effective_config_toml(session.scene()),
                    .files = files_of(session.scene(), names_.scene),
                    .composition = engine.composition().name,
                    .snapshot_bytes = engine.snapshot_bytes(),
                    .log_origin_ns = log_origin_ns_,
                    .revision = std::string(revision()),
                    .device_start = {}};
  const JointVector q = joints_at_start(session.scene(), session.motion());
  head.device_start.assign(q.begin(), q.end());
  if (!names_.inputs.empty()) input_log_.emplace(names_.inputs, waiting_bytes);
  if (!names_.on_fault.empty())
    fault_log_.emplace(names_.on_fault, sizes_of(start), head.snapshot_bytes, session.scene().step);
  inputs_.emplace(std::move(head), start, [this](const InputLogWriter::Chunk& chunk) {
    if (input_log_) input_log_->add(chunk.bytes, chunk.num_rows, patience_);
    if (fault_log_) fault_log_->add(chunk, patience_);
  });
  inputs_->add(state_of(session));
}

void RunFiles::add(const CycleRecord& record) {
  if (record.cycle == 0) {
    start_ = record;
    return;
  }
  if (inputs_) inputs_->add(record);
  if (start_) {
    start_->t_bus_ns = record.motion_start_ns;
    start_->device_q = record.device_q;  // unknown before the first step
  }
  add_start();
  write(record);
}

/// Writes the state before the first step, once.
void RunFiles::add_start() {
  if (start_) write(*start_);
  start_.reset();
}

void RunFiles::write(const CycleRecord& record) {
  if (nets_ && num_rows_ % names_.nets_every == 0) nets_->row(record.t, record.net_nodes);
  if (!is_kept(record)) return;
  if (trace_) add_row(record);
  if (contacts_) contacts_->rows(record.t, std::span(record.touching).first(record.num_touching));
}

bool RunFiles::is_kept(const CycleRecord& record) noexcept {
  const bool changed = record.fault != fault_ || record.rig_faults != rig_faults_;
  fault_ = record.fault;
  rig_faults_ = record.rig_faults;
  return num_rows_++ % names_.trace_every == 0 || changed;
}

void RunFiles::add_row(const CycleRecord& record) {
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    bodies_[i] = {
        .X_WB = record.bodies[i].X_WB, .V_WB = record.bodies[i].V_WB, .contact = record.bodies[i].contact_W};
  for (std::size_t i = 0; i < driven_.size(); ++i) {
    const BodyView& body = record.bodies[driven_[i]];
    pulls_[i] = {.coupling = body.coupling_B, .feedback = body.feedback_D, .X_WD = body.target.X_WD};
  }
  for (std::size_t i = 0; i < children_.size(); ++i) joints_[i] = record.bodies[children_[i]].joint_C;
  std::ranges::copy(record.term_forces, joints_.begin() + static_cast<std::ptrdiff_t>(children_.size()));
  trace_->row(
      record.t, bodies_, pulls_, joints_,
      {.contacts = record.contacts,
       .nets = record.nets,
       .net_stretch = record.net_stretch,
       .held = record.held,
       .hand = record.hand_W,
       .energy = record.energy.total,
       .energy_balance = record.energy.balance},
      {.fault = static_cast<std::uint32_t>(record.fault),
       .limited = static_cast<std::uint32_t>(record.limited),
       .rig_fault = static_cast<std::uint32_t>(record.rig_faults)},
      {.t_bus = record.t_bus_ns == 0 ? 0 : 1e-9 * static_cast<double>(record.t_bus_ns + log_origin_ns_),
       .targets = record.targets,
       .joint_q = record.joint_q,
       .device_q = record.device_q,
       .drive_torque = record.drive_torque,
       .drive_energy = record.drive_energy});
}

const FaultFile* RunFiles::write_on_fault() {
  if (!fault_log_ || !fault_log_->wants_file()) return nullptr;
  inputs_->flush();
  return &fault_log_->write(patience_);
}

std::vector<FileLoss> RunFiles::close() {
  add_start();
  if (trace_) static_cast<void>(trace_->close());  // the file reports losses
  if (contacts_) static_cast<void>(contacts_->close());
  if (nets_) static_cast<void>(nets_->close());
  if (record_) static_cast<void>(record_->close());
  if (inputs_) inputs_->flush();
  if (input_log_) input_log_->add(InputLogWriter::end_of(input_log_->refused_rows()), 0, patience_);
  const auto until = BackgroundFile::Clock::now() + close_patience;
  std::vector<FileLoss> losses;
  const auto close_one = [&](std::optional<BackgroundFile>& file, const std::string& path) {
    if (!file) return;
    BackgroundFile::Result result = file->close(until);
    if (!result.why.empty() || result.lost_lines > 0)
      losses.push_back({.path = path, .why = std::move(result.why), .lost_lines = result.lost_lines});
  };
  close_one(trace_file_, names_.trace);
  close_one(contacts_file_, names_.contacts);
  close_one(nets_file_, names_.nets);
  close_one(record_file_, names_.record);
  if (input_log_)
    if (std::optional<FileLoss> loss = input_log_->close(until)) losses.push_back(*std::move(loss));
  if (fault_log_)
    for (FileLoss& loss : fault_log_->close(until)) losses.push_back(std::move(loss));
  return losses;
}

}  // namespace godobject
