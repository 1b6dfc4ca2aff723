#include "hal/tracker/polhemus_tracker.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>

namespace godobject {
namespace {

constexpr Nanoseconds millisecond = 1'000'000;
// pause between commands, because neither model answers
constexpr Nanoseconds command_period = 60 * millisecond;
constexpr Nanoseconds record_patience = 1000 * millisecond;  // limit for the first record, and then for each
constexpr double max_speed = 10;                             // m/s
constexpr double max_jump = 0.02;                            // m, independent of the time between two records
// consecutive records; the next one is accepted as real motion
constexpr int max_refused = 3;

std::uint8_t station_of(const std::string& tool) {
  unsigned station = 0;
  const auto [end, error] = std::from_chars(tool.data(), tool.data() + tool.size(), station);
  const bool good =
      error == std::errc() && end == tool.data() + tool.size() && station <= polhemus::max_stations;
  return good ? static_cast<std::uint8_t>(station) : std::uint8_t{0};
}

}  // namespace

std::unique_ptr<Tracker> make_polhemus_tracker(const TrackerParams& params,
                                               std::vector<std::string>& errors) {
  for (const TrackedToolParams& tool : params.tools) {
    if (station_of(tool.tool) == 0)
      errors.push_back("tracker '" + params.name + "': tool '" + tool.tool +
                       "' must be the number of a station, 1 to " + std::to_string(polhemus::max_stations));
  }
  if (!errors.empty()) return nullptr;
  return std::make_unique<PolhemusTracker>(params);
}

PolhemusTracker::PolhemusTracker(const TrackerParams& params) : Tracker(params) {
  for (std::size_t i = 0; i < params.tools.size(); ++i) {
    stations_[i] = station_of(params.tools[i].tool);
    num_stations_ = std::max<std::size_t>(num_stations_, stations_[i]);
  }
}

void PolhemusTracker::opened(Nanoseconds now) noexcept {
  boot_deadline_ = now + std::llround(params_.boot_timeout_s * 1e9);
  report_.state = TrackerState::initialising;
  begin(now);
}

/// Begins the set-up for the other model.
void PolhemusTracker::begin(Nanoseconds now) noexcept {
  model_ = model_ == polhemus::Model::liberty ? polhemus::Model::fastrak : polhemus::Model::liberty;
  index_ = frame_index_ = 0;
  unread_.clear();
  not_before_ = now;
  receiver_.reset();
  time_ms_.reset();
  clock_.reset();
  for (Plausibility& last : last_) last.started = false;
  const char* const what = model_ == polhemus::Model::fastrak ? "a Fastrak" : "a Liberty";
  if (report_.state == TrackerState::initialising)
    enter(TrackerState::initialising, "setting up %.60s as %s", params_.port.c_str(), what);
}

LineRequest PolhemusTracker::next(Nanoseconds now) noexcept {
  expire(now);
  // Frames are set after the first commands (stop, units) and before those for records.
  command_ = index_ == 2 ? polhemus::frame_command(model_, frame_index_, num_stations_, params_.hemisphere)
                         : std::nullopt;
  const bool sets_frame = command_.has_value();
  if (!command_) command_ = polhemus::init_command(model_, index_, num_stations_);
  if (command_) {
    if (now < not_before_) return {};
    ++(sets_frame ? frame_index_ : index_);
    not_before_ = now + command_period;
    deadline_ = now + record_patience;
    return {.kind = LineRequest::Kind::send, .bytes = command_->bytes()};
  }
  if (now < deadline_) return {};
  ++report_.counters.timeouts;
  std::array<char, 140> why{};
  if (unread_.empty())
    std::snprintf(why.data(), why.size(),
                  "check that the tracker is switched on, connected to this port and set to %u bit/s",
                  unsigned{params_.baud});
  else unread_.describe(TrackerProtocol::polhemus, params_.baud, why);
  if (report_.state == TrackerState::tracking) {
    ++report_.counters.restarts;
    boot_deadline_ = now + std::llround(params_.boot_timeout_s * 1e9);
    report_.state = TrackerState::initialising;
  } else if (now >= boot_deadline_) {
    report_.state = TrackerState::failed;
  }
  begin(now);
  enter(report_.state, "no records: %s", why.data());
  return {};
}

void PolhemusTracker::receive(std::span<const std::uint8_t> bytes, Nanoseconds now) noexcept {
  unread_.add(bytes);
  // records received during set-up are of an earlier run, in another format
  if (polhemus::init_command(model_, index_, num_stations_)) return;
  for (const std::uint8_t byte : bytes) {
    switch (receiver_.push(byte)) {
      case polhemus::RecordReceiver::Event::more: break;
      case polhemus::RecordReceiver::Event::malformed: ++report_.counters.malformed; break;
      case polhemus::RecordReceiver::Event::record: take(receiver_.record(), now); break;
    }
  }
}

void PolhemusTracker::take(const polhemus::Record& record, Nanoseconds now) noexcept {
  unread_.clear();
  deadline_ = now + record_patience;
  const double wire_s = 10.0 * static_cast<double>(polhemus::fastrak_size) / params_.baud;
  Nanoseconds t = now - to_ns(wire_s);
  if (record.model == polhemus::Model::liberty) {
    const Nanoseconds t_tracker = millisecond * time_ms_.unwrap(record.t_ms);
    clock_.add(t_tracker, now);
    t = std::min(clock_.to_host(t_tracker), now);
  }
  for (std::size_t i = 0; i < params_.tools.size(); ++i) {
    if (stations_[i] != record.station) continue;
    const bool was_mirrored = last_[i].mirrored;
    const Verdict verdict = judge(last_[i], record.X_TH.p, t);
    if (verdict == Verdict::refused) {
      ++report_.counters.malformed;
      return;
    }
    if (verdict == Verdict::mirrored) {
      not_measured(i, ToolState::missing, t);
      enter(TrackerState::tracking,
            "station %u has left the hemisphere (%.2g, %.2g, %.2g) of its source: bring it back, or set "
            "`hemisphere`",
            unsigned{record.station}, params_.hemisphere.x(), params_.hemisphere.y(), params_.hemisphere.z());
      return;
    }
    measured(i, record.X_TH, ++count_[i], 0, ToolState::valid, t);
    if (was_mirrored || report_.state != TrackerState::tracking) report_tracking(record);
  }
}

void PolhemusTracker::report_tracking(const polhemus::Record& record) noexcept {
  enter(TrackerState::tracking, "%s, station %u%s",
        record.model == polhemus::Model::fastrak ? "Fastrak" : "Liberty", unsigned{record.station},
        record.error == ' ' ? "" : " reports a weak or disturbed signal");
}

/// Checks a position. The field of the source is equal at p and -p: a sensor that leaves its hemisphere is
/// reported at -p. It then counts as lost until it returns, for any duration; any other jump is accepted if
/// it persists.
PolhemusTracker::Verdict PolhemusTracker::judge(Plausibility& last, const Vec3& p, Nanoseconds t) noexcept {
  const double dt = 1e-9 * static_cast<double>(std::max<Nanoseconds>(t - last.t_ns, 0));
  const double way = max_jump + max_speed * dt;
  const double to_it = (p - last.p).norm(), to_mirror_image = (p + last.p).norm();
  const bool is_near = !last.started || to_it <= way;
  const bool is_mirrored = last.started && to_it > max_jump && to_mirror_image < to_it &&
                           to_mirror_image <= (is_near ? max_jump : way);
  if (is_mirrored) {
    last = {.p = -p, .t_ns = t, .refused = 0, .started = true, .mirrored = true};
    return Verdict::mirrored;
  }
  if (!is_near && ++last.refused < max_refused) return Verdict::refused;
  last = {.p = p, .t_ns = t, .refused = 0, .started = true};
  return Verdict::plausible;
}

}  // namespace godobject
