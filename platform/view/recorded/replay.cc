#include "platform/view/recorded/recording.h"

#include <algorithm>
#include <memory>

#include "platform/rig/log_link.h"
#include "platform/session/session.h"

namespace godobject {
RecordingResult replay_log(const std::string& log, const std::string& scene_path, const SceneConfig& scene) {
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
  Recording recording{.scene = session.scene(), .samples = {}};
  ViewSample sample{.record = session.at_start(), .counters = {}, .touching = {}};
  sample.touching.resize(session.engine().composition().all_contacts());
  sample.net_nodes.resize(session.engine().nets().nodes.size());
  double due = 0;
  while (!read.ended() && session.phase() != RunPhase::ended) {
    const bool stepped = session.advance(sample.record);
    if (stepped) sample.record.t += 1e-9 * static_cast<double>(read.skipped());
    if (!stepped || sample.record.t < due || recording.samples.size() >= max_recorded) continue;
    due = std::max(due + 1 / recorded_rate_hz, sample.record.t);
    sample.phase = session.phase();
    sample.num_touching = session.engine().contacts(sample.touching);
    session.engine().net_nodes(sample.net_nodes);
    recording.samples.push_back(sample);
    recording.samples.back().touching.resize(sample.num_touching);
  }
  if (recording.samples.empty())
    result.errors.push_back(log +
                            ": the scene's device does not boot by these frames: the log must begin before "
                            "the run's first frame");
  else result.recording = std::move(recording);
  if (read.skipped() > 0)
    result.notes.push_back(log + ": the host was silent for " +
                           std::to_string(read.skipped() / 1'000'000'000) +
                           " s in all: these gaps were skipped; the view stands still in them");
  return result;
}

}  // namespace godobject
