// A simulated Polhemus tracker: Fastrak or Liberty. It answers nothing and sends records once it is told to.
#pragma once

#include "hal/tracker/polhemus.h"
#include "sim/tracker/tracker.h"

namespace godobject {

class SimPolhemus final : public SimTracker {
 public:
  SimPolhemus(const TrackerParams& params, double rate_hz, std::uint64_t seed,
              polhemus::Model model = polhemus::Model::fastrak);

  void receive(std::span<const std::uint8_t> bytes, Nanoseconds now) noexcept override;

 private:
  void obey(std::span<const std::uint8_t> command) noexcept;
  void measured(Nanoseconds now) noexcept override;

  polhemus::Model model_;
  std::array<std::uint8_t, max_tracked_tools> stations_{};
  std::size_t num_tools_ = 0;
  std::array<std::uint8_t, 64> line_{};
  std::size_t line_size_ = 0;
  bool binary_ = false, continuous_ = false;
  std::array<bool, polhemus::max_stations + 1> has_format_{};  // by station: position and quaternion
};

}  // namespace godobject
