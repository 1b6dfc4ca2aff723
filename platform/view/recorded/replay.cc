#include "platform/view/recorded/replay.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <memory>

#include "hal/can/candump.h"
#include "hal/canopen/canopen.h"
#include "hal/drive/link.h"
#include "platform/session/session.h"

namespace godobject {
namespace {

constexpr std::size_t max_log_bytes = std::size_t{512} << 20;

/// What one bus of the log has, by now.
class LoggedBus final : public CanBus {
 public:
  explicit LoggedBus(const Nanoseconds& now) : now_(now) {}
  bool open() noexcept override { return true; }
  void close() noexcept override {}
  void add(const ReceivedFrame& frame) { frames_.push_back(frame); }
  Nanoseconds next() const noexcept { return next_ < frames_.size() ? frames_[next_].t_ns : end_of_time; }

  SendResult try_send(const CanFrame& /*frame*/) noexcept override { return SendResult::queued; }
  bool try_receive(ReceivedFrame& out) noexcept override {
    if (next() > now_) return false;
    out = frames_[next_++];
    return true;
  }
  BusState state() const noexcept override { return BusState::error_active; }
  BusCounters counters() const noexcept override { return {}; }

  static constexpr Nanoseconds end_of_time = std::numeric_limits<Nanoseconds>::max();

 private:
  const Nanoseconds& now_;
  std::vector<ReceivedFrame> frames_;
  std::size_t next_ = 0;
};

/// The buses of the log. A cycle begins at a SYNC of the log, and where there is none, a period after the last.
class LogLink final : public RigLink {
 public:
  LogLink(const RigParams& rig, Nanoseconds period) : rig_(rig), period_(period) {
    for (std::size_t i = 0; i < rig.buses.size(); ++i) buses_.push_back(std::make_unique<LoggedBus>(now_));
    for (const auto& bus : buses_) ports_.push_back(bus.get());
  }
  void add(std::size_t bus, const ReceivedFrame& frame) {
    if (bus == 0 && !frame.frame.extended && frame.frame.id == canopen::make_sync().id)
      syncs_.push_back(frame.t_ns);
    else if (!is_of_host(bus, frame.frame)) buses_[bus]->add(frame);
    end_ = std::max(end_, frame.t_ns);
    if (now_ == 0) now_ = frame.t_ns - period_;
  }
  bool ended() const noexcept { return now_ >= end_; }

  std::span<CanBus* const> buses() noexcept override { return ports_; }
  Nanoseconds begin_cycle(double /*motion_time*/) noexcept override {
    while (next_sync_ < syncs_.size() && syncs_[next_sync_] <= began_) ++next_sync_;
    const Nanoseconds due = std::max(began_ == 0 ? now_ : began_ + period_, now_);
    const bool has_sync = next_sync_ < syncs_.size() && syncs_[next_sync_] < due + period_ / 2;
    began_ = now_ = has_sync ? std::max(now_, syncs_[next_sync_]) : due;
    return now_;
  }
  Nanoseconds wait(Nanoseconds until) noexcept override {
    Nanoseconds next = until;
    for (const auto& bus : buses_) next = std::min(next, std::max(bus->next(), now_));
    return now_ = std::max(now_, next);
  }
  void end_cycle() noexcept override {}
  void set_observer(const BusObserver& /*observer*/) noexcept override {}

 private:
  /// A host does not hear itself.
  bool is_of_host(std::size_t bus, const CanFrame& frame) const noexcept {
    if (!frame.extended && canopen::is_from_master(frame, rig_.host_node_id)) return true;
    return std::ranges::any_of(rig_.drives, [&](const DriveParams& drive) {
      return drive.bus == bus && bus_protocol(drive.protocol).commanded(frame) == drive.node_id;
    });
  }

  const RigParams& rig_;
  Nanoseconds period_, now_ = 0, began_ = 0, end_ = 0;
  std::vector<std::unique_ptr<LoggedBus>> buses_;
  std::vector<CanBus*> ports_;
  std::vector<Nanoseconds> syncs_;
  std::size_t next_sync_ = 0;
};

/// Fills the link; empty, or what is wrong with the log.
std::string read_log(const std::string& path, const std::vector<BusParams>& buses, LogLink& link) {
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  if (!in) return path + ": cannot be read";
  if (static_cast<std::size_t>(in.tellg()) > max_log_bytes) return path + ": larger than 512 MiB";
  in.seekg(0);
  std::size_t number = 0, num_frames = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    ReceivedFrame frame;
    std::string_view name;
    const CandumpResult result = parse_candump(line, frame, name);
    if (result == CandumpResult::ignored || result == CandumpResult::error_frame) continue;
    if (result != CandumpResult::ok && in.eof()) break;  // cut off with the program that wrote it
    if (result != CandumpResult::ok)
      return path + ":" + std::to_string(number) +
             ": no line of a log, as candump -l or godobject run --record writes it";
    const auto bus = std::ranges::find(buses, name, &BusParams::name);
    if (bus == buses.end()) continue;
    link.add(static_cast<std::size_t>(bus - buses.begin()), frame);
    ++num_frames;
  }
  return num_frames > 0 ? ""
                        : path +
                              ": holds no frame of the scene's buses: is it of another scene? Give its file "
                              "with --scene";
}

}  // namespace

RecordingResult replay_log(const std::string& log, const std::string& scene_path, const SceneConfig& scene) {
  RecordingResult result;
  if (!scene.device || !scene.device->rig) {
    result.errors.push_back(scene_path + ": scene '" + scene.name + "' describes no buses, and " + log +
                            " is no trace (.csv)");
    return result;
  }
  auto link = std::make_unique<LogLink>(*scene.device->rig, to_ns(scene.step));
  LogLink& read = *link;
  if (std::string why_not = read_log(log, scene.device->rig->buses, read); !why_not.empty()) {
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
    if (!session.advance(sample.record) || sample.record.t < due || recording.samples.size() >= max_recorded)
      continue;
    due += 1 / recorded_rate_hz;
    sample.phase = session.phase();
    sample.num_touching = session.engine().contacts(sample.touching);
    session.engine().net_nodes(sample.net_nodes);
    recording.samples.push_back(sample);
    recording.samples.back().touching.resize(sample.num_touching);
  }
  if (recording.samples.empty())
    result.errors.push_back(
        log +
        ": the scene's device does not come up by these frames: does the log begin before the run's first?");
  else result.recording = std::move(recording);
  return result;
}

}  // namespace godobject
