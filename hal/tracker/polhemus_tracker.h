// Polhemus Fastrak, Liberty or Patriot, from the opened line to poses. The model is detected by its records:
// the set-ups of both are tried alternately. A tool is named by its station, beginning with "1". t_ns of a
// sample: for Liberty its own clock mapped to the host's; for Fastrak, which has none, arrival minus time on
// the wire.
#pragma once

#include <optional>

#include "hal/base/clock_map.h"
#include "hal/tracker/polhemus.h"
#include "hal/tracker/tracker.h"
#include "hal/tracker/unread_bytes.h"

namespace godobject {

std::unique_ptr<Tracker> make_polhemus_tracker(const TrackerParams& params, std::vector<std::string>& errors);

class PolhemusTracker final : public Tracker {
 public:
  explicit PolhemusTracker(const TrackerParams& params);

  std::uint32_t first_baud() const noexcept override { return params_.baud; }
  void opened(Nanoseconds now) noexcept override;
  void receive(std::span<const std::uint8_t> bytes, Nanoseconds now) noexcept override;
  LineRequest next(Nanoseconds now) noexcept override;

 private:
  /// Limits the effect of noise on a position: faster motion than a hand's is refused unless it persists.
  struct Plausibility {
    Vec3 p = Vec3::Zero();  // position of the sensor; for mirrored records, the mirrored position
    Nanoseconds t_ns = 0;
    int refused = 0;
    bool started = false;
    bool mirrored = false;  // the sensor has left its hemisphere: records contain -p
  };
  enum class Verdict : std::uint8_t { plausible, mirrored, refused };

  void begin(Nanoseconds now) noexcept;
  void take(const polhemus::Record& record, Nanoseconds now) noexcept;
  static Verdict judge(Plausibility& last, const Vec3& p, Nanoseconds t) noexcept;
  void report_tracking(const polhemus::Record& record) noexcept;

  polhemus::RecordReceiver receiver_;
  UnreadBytes unread_;
  polhemus::Model model_ = polhemus::Model::liberty;
  std::optional<polhemus::Command> command_;
  std::size_t index_ = 0;        // index of the initialisation command
  std::size_t frame_index_ = 0;  // index of the command that sets frames
  std::size_t num_stations_ = 1;
  std::array<std::uint8_t, max_tracked_tools> stations_{};
  std::array<Plausibility, max_tracked_tools> last_{};
  std::array<std::uint32_t, max_tracked_tools> count_{};  // records per tool
  UnwrappedCount time_ms_;
  ClockMap clock_;
  Nanoseconds not_before_ = 0;     // earliest time of the next command
  Nanoseconds deadline_ = 0;       // deadline of the next record
  Nanoseconds boot_deadline_ = 0;  // deadline for tracking to begin
};

}  // namespace godobject
