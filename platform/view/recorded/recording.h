// Recordings as frames: a trace of a scene, with the nodes of its nets, logs of its buses, or only the start
// of the scene.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "platform/scene/scene.h"
#include "platform/view/drawing.h"
#include "platform/view/frame.h"
#include "platform/view/server/server.h"

namespace godobject {

/// Recorded positions of the nodes of nets, as written by `run --nets`; traces do not contain them.
class NetRecording {
 public:
  NetRecording(std::vector<double> times, std::vector<float> nodes);

  /// Returns the positions at time t, s: linear between two rows, constant before the first and after the
  /// last.
  std::vector<Vec3> at(double t) const;
  double begin() const noexcept { return times_.front(); }
  double end() const noexcept { return times_.back(); }
  std::size_t num_rows() const noexcept { return times_.size(); }

 private:
  std::vector<double> times_;  // s, ascending; at least one
  std::vector<float> nodes_;   // row by row
};

struct NetRecordingResult {
  std::optional<NetRecording> nets;  // absent if there are errors
  std::vector<std::string> errors;
};
/// Reads the nets' file of a run of this scene.
NetRecordingResult read_nets(const std::string& path, const SceneConfig& scene);

/// Displayed instants of a trace.
struct Recording {
  SceneConfig scene;
  std::vector<ViewSample> samples;     // at least one, in the order of time
  std::optional<NetRecording> nets{};  // absent: positions of nodes were not recorded
};

/// Returns the positions of the nodes, world, m: those of the sample, of the recorded nets, or else the
/// nodes' anchors.
std::vector<Vec3> nodes_of(const Recording& recording, const SceneNets& nets, const ViewSample& sample);

/// Highest rate of a page's instants, per second, and their largest number; instants between them are left
/// out.
inline constexpr double recorded_rate_hz = 100;
inline constexpr std::size_t max_recorded = 20000;
/// Limit on the bytes of nodes for a page; further instants are left out.
inline constexpr std::size_t max_recorded_net_bytes = std::size_t{256} << 20;

/// Returns the start of the scene as a recording.
Recording recording_of(const SceneConfig& scene);

struct RecordingResult {
  std::optional<Recording> recording;  // absent if there are errors
  std::vector<std::string> errors, notes{};
};
/// Reads a trace that `run --trace` wrote of this scene.
RecordingResult read_trace(const std::string& path, const SceneConfig& scene);

/// Returns the sample nearest to time t, s; without t the last one.
const ViewSample& sample_at(const Recording& recording, std::optional<double> t);

/// A recording as the source of pages.
class RecordedView final : public ViewSource {
 public:
  RecordedView(const Recording& recording, const ViewAbout& about);

  std::string scene() override { return scene_; }
  ViewBytes recording() override { return frames_; }

 private:
  std::string scene_;
  ViewBytes frames_;
};

/// Recomputes a recording from logs of buses: rig and core process the frames at the times of the log. log:
/// file of `run --record` with all buses of the scene. scene_path: file of the scene, for profiles beside it.
RecordingResult replay_log(const std::string& log, const std::string& scene_path, const SceneConfig& scene);

// Rows of numbers, as in traces, read one at a time, because long runs are not stored as a whole.

/// Returns the names of a first line.
std::vector<std::string> split_at_commas(std::string_view line);
/// Returns false unless the line has exactly numbers.size() numbers.
bool read_numbers(std::string_view line, std::span<double> numbers);

using UseNames = std::function<std::string(const std::vector<std::string>& names)>;
using UseRow = std::function<std::string(const std::string& line)>;

/// Reads a file: passes its first line to begin(names) and each row to add(line). Both return empty or an
/// error. Returns empty or the first error. A last line without its end is left out.
/// is_cut: set to true if there is such a line; null: not needed.
std::string read_rows(const std::string& path, const UseNames& begin, const UseRow& add,
                      bool* is_cut = nullptr);

/// Recomputes logs of buses as replay_log() does, and passes every step as a row of a trace, as read_rows()
/// does. The columns of joints, energy and faults are 0. The result has no recording.
RecordingResult replay_rows(const std::string& log, const std::string& scene_path, const SceneConfig& scene,
                            const UseNames& begin, const UseRow& add);

}  // namespace godobject
