// Simulated Polhemus tracker: Fastrak or Liberty. It sends records after the command for them, as text until
// the command for binary ones. Unknown commands get an error.
#pragma once

#include <string_view>

#include "hal/tracker/polhemus.h"
#include "sim/tracker/tracker.h"

namespace godobject {

class SimPolhemus final : public SimTracker {
 public:
  /// Settings of a station that transform its poses; they persist beyond a host.
  struct Saved {
    Pose X_alignment{};                 // frame of the records in the source's frame
    Quat boresight = Quat::Identity();  // rotation of the sensor
    Vec3 tip = Vec3::Zero();            // offset in the sensor's frame, m
    Quat source = Quat::Identity();     // rotation of the source
  };

  SimPolhemus(const TrackerParams& params, double rate_hz, std::uint64_t seed,
              polhemus::Model model = polhemus::Model::fastrak);

  void receive(std::span<const std::uint8_t> bytes, Nanoseconds now) noexcept override;

  void save(std::size_t tool, const Saved& saved) noexcept { saved_[tool] = saved; }
  /// Sets whether records are mirrored at the source while the sensor is outside the hemisphere.
  void set_half_space(bool half_space) noexcept { half_space_ = half_space; }
  /// Sets whether it keeps sending text, as hardware switches can select.
  void set_text_only(bool text_only) noexcept { text_only_ = text_only; }

 private:
  void obey(std::span<const std::uint8_t> command, Nanoseconds now) noexcept;
  bool set_frame(std::string_view text) noexcept;
  Pose reported(std::size_t tool) const noexcept;
  void measured(Nanoseconds now) noexcept override;

  polhemus::Model model_;
  std::array<std::uint8_t, max_tracked_tools> stations_{};
  std::size_t num_tools_ = 0;
  std::array<std::uint8_t, 64> line_{};
  std::size_t line_size_ = 0;
  std::array<Saved, max_tracked_tools> saved_{};
  std::array<Vec3, max_tracked_tools> hemispheres_{};
  bool binary_ = false, continuous_ = false, half_space_ = false, text_only_ = false;
  std::array<bool, polhemus::max_stations + 1> has_format_{};  // by station: position and quaternion
};

}  // namespace godobject
