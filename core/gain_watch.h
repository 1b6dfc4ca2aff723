// Detection of energy gains that are faults (38), from E - W of each step.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/tuning.h"

namespace godobject {

/// Detects increases of E - W. The energy at work is the largest kinetic energy in the window plus the work
/// done in it, including gravity's.
class GainWatch {
 public:
  /// Starts with E before the first step.
  void start(Real E) noexcept {
    *this = {};
    last_.fill(E);
  }
  /// Adds a step. work: work done in it, J. floor: gains below it are ignored, J.
  void observe(Real E_less_W, Real T, Real work, Real floor, Real h) noexcept {
    age_ += h;
    if (!std::isfinite(E_less_W) || !std::isfinite(T) || !std::isfinite(work) || !std::isfinite(floor)) {
      gains_ = true;  // the window keeps its finite figures, which later steps are compared with
      gained_ = std::numeric_limits<Real>::max();
      return;
    }
    last_[next_] = E_less_W;
    next_ = (next_ + 1) % gain_steps;
    const auto [kept, reached] = std::minmax_element(last_.begin(), last_.end());
    if (age_ >= gain_window / 2) {
      before_ = now_;
      now_ = {.least = *reached};
      age_ = 0;
    }
    now_.least = std::min(now_.least, *reached);
    now_.kinetic = std::max(now_.kinetic, T);
    now_.work += work;
    gained_ = std::max(*kept - std::min(now_.least, before_.least), Real(0));
    of_ = std::max(now_.kinetic, before_.kinetic) + now_.work + before_.work;
    gains_ = gained_ > gain_allowed * of_ + floor;
  }
  bool gains() const noexcept { return gains_; }
  Real gained() const noexcept { return gained_; }  // J within the window
  Real at_work() const noexcept { return of_; }     // J likewise

 private:
  struct Span {
    Real least = std::numeric_limits<Real>::infinity(), kinetic = 0, work = 0;
  };
  Span now_, before_;
  std::array<Real, gain_steps> last_{};  // E - W of the last steps
  std::size_t next_ = 0;
  Real age_ = 0, gained_ = 0, of_ = 0;
  bool gains_ = false;
};

}  // namespace godobject
