#include "platform/view/recorded/recording.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "platform/rig/log_link.h"
#include "platform/session/session.h"
#include "platform/trace/trace.h"

namespace godobject {
namespace {

/// Receives the session and each step; its time is that of the log. Returns false if no more are needed.
using UseStep = std::function<bool(Session& session, const CycleRecord& record)>;

/// Recomputes the steps of a log. The result has no recording.
RecordingResult replay(const std::string& log, const std::string& scene_path, const SceneConfig& scene,
                       const UseStep& use) {
  RecordingResult result;
  if (!scene.device || !scene.device->rig) {
    result.errors.push_back(scene_path + ": scene '" + scene.name + "' describes no buses, and " + log +
                            " is no trace (.csv)");
    return result;
  }
  auto link = std::make_unique<LogLink>(*scene.device->rig, to_ns(scene.step));
  LogLink& read = *link;
  const std::vector<LogSource> sources(scene.device->rig->buses.size(), {.path = log, .interface = ""});
  if (std::string why_not = read.read(sources); !why_not.empty()) {
    result.errors.push_back(std::move(why_not));
    return result;
  }
  Session::Made made = Session::make(scene, Motion(scene), std::move(link));
  result.errors = std::move(made.errors);
  if (!made.session) return result;
  Session& session = *made.session;
  constexpr double boot_limit_s = 60;
  session.start(boot_limit_s);
  CycleRecord record = session.at_start();
  bool any_step = false, goes_on = true;
  while (goes_on && !read.ended() && session.phase() != RunPhase::ended) {
    if (!session.advance(record)) continue;
    any_step = true;
    record.t += 1e-9 * static_cast<double>(read.skipped());
    goes_on = use(session, record);
  }
  if (!any_step)
    result.errors.push_back(log +
                            ": the scene's device does not boot by these frames: the log must begin before "
                            "the run's first frame");
  if (read.skipped() > 0)
    result.notes.push_back(log + ": the host was silent for " +
                           std::to_string(read.skipped() / 1'000'000'000) +
                           " s in all: these gaps were skipped");
  return result;
}

}  // namespace

RecordingResult replay_log(const std::string& log, const std::string& scene_path, const SceneConfig& scene) {
  std::optional<Recording> recording;
  ViewSample sample{.record = {}, .counters = {}, .touching = {}};
  double due = 0;
  RecordingResult result = replay(log, scene_path, scene, [&](Session& session, const CycleRecord& record) {
    if (!recording) {
      recording.emplace(Recording{.scene = session.scene(), .samples = {}});
      sample.net_nodes.resize(session.engine().nets().nodes.size());
    }
    if (record.t < due) return true;
    due = std::max(due + 1 / recorded_rate_hz, record.t);
    sample.record = record;
    sample.phase = session.phase();
    sample.touching.resize(session.engine().composition().all_contacts());
    sample.num_touching = session.engine().contacts(sample.touching);
    sample.touching.resize(sample.num_touching);
    session.engine().net_nodes(sample.net_nodes);
    recording->samples.push_back(sample);
    return recording->samples.size() < max_recorded;
  });
  for (std::string& note : result.notes) note += "; the view stands still in them";
  if (result.errors.empty()) result.recording = std::move(recording);
  return result;
}

RecordingResult replay_rows(const std::string& log, const std::string& scene_path, const SceneConfig& scene,
                            const UseNames& begin, const UseRow& add) {
  const std::vector<std::size_t> driven = driven_bodies(scene);
  std::vector<TraceBody> bodies(scene.bodies.size());
  std::vector<TraceDriven> pulls(driven.size());
  const std::vector<Wrench> joints(scene.joints.size());  // not computed for a row
  std::string why_not = begin(trace_columns(scene));
  bool has_header = false;
  const auto sink = [&](std::string_view text) {
    text.remove_suffix(1);  // the line's end
    if (std::exchange(has_header, true) && why_not.empty()) why_not = add(std::string(text));
    return true;
  };
  TraceWriter writer(CsvRows::Sink(sink), scene);
  RecordingResult result = replay(log, scene_path, scene, [&](Session&, const CycleRecord& record) {
    for (std::size_t i = 0; i < bodies.size(); ++i)
      bodies[i] = {.X_WB = record.bodies[i].X_WB,
                   .V_WB = record.bodies[i].V_WB,
                   .contact = record.bodies[i].contact_W};
    for (std::size_t i = 0; i < driven.size(); ++i) {
      const BodyView& body = record.bodies[driven[i]];
      pulls[i] = {.coupling = body.coupling_B, .feedback = body.feedback_D, .X_WD = body.target.X_WD};
    }
    writer.row(record.t, bodies, pulls, joints, {.held = record.held, .hand = record.hand_W}, {},
               {.targets = record.targets});
    return why_not.empty();
  });
  if (!why_not.empty()) result.errors.push_back(log + ": " + why_not);
  return result;
}

}  // namespace godobject
