#include "hal/joint/encoder.h"

#include <bit>
#include <cmath>

namespace godobject {

namespace {

constexpr std::int64_t counts_of_32_bits = std::int64_t{1} << 32;

}  // namespace

Encoder::Encoder(const Calibration& calibration, double max_speed, Nanoseconds stale_after_ns) noexcept
    : calibration_(calibration),
      modulus_counts_(calibration.modulus_counts == 0
                          ? counts_of_32_bits
                          : static_cast<std::int64_t>(calibration.modulus_counts)),
      max_speed_counts_per_ns_(1e-9 * max_speed * calibration.counts_per_unit),
      stale_after_ns_(stale_after_ns),
      velocity_(1 / calibration.counts_per_unit),
      has_zero_(!calibration.incremental) {}

void Encoder::update(std::uint32_t raw_counts, Nanoseconds t_ns) noexcept {
  const Reading reading{raw_counts, t_ns};
  if (has_reference_ && t_ns <= reference_.t_ns) {
    ++counters_.out_of_order;
    return;
  }
  if (static_cast<std::int64_t>(raw_counts) >= modulus_counts_) {
    agreeing_ = 0;
    last_was_accepted_ = false;
    ++counters_.implausible;
    vote(true);
  } else if (!has_reference_) {
    anchor(reading);
  } else if (far_from(t_ns - reference_.t_ns)) {
    ++counters_.resyncs;
    anchor(reading);
  } else if (plausible(reference_, reading)) {
    accept(reading);
  } else {
    reject(reading);
  }
}

JointSample Encoder::sample(Nanoseconds now) const noexcept {
  JointSample out;
  out.q = calibration_.home + from_home();
  out.q_dot = stale(now) ? 0 : q_dot_;
  out.valid = good(now) && has_zero_;
  out.t_ns = reference_.t_ns;
  return out;
}

bool Encoder::stale(Nanoseconds now) const noexcept {
  return !has_reference_ || now - reference_.t_ns > stale_after_ns_;
}

double Encoder::from_home() const noexcept {
  return calibration_.sign * static_cast<double>(counts_) / calibration_.counts_per_unit;
}

bool Encoder::trusted() const noexcept { return std::popcount(rejected_history_) < votes_needed; }

// Returns to - from modulo the modulus, in [-modulus/2, modulus/2).
std::int64_t Encoder::signed_difference(std::int64_t to, std::int64_t from) const noexcept {
  const std::int64_t half = modulus_counts_ / 2;
  std::int64_t difference = (to - from + half) % modulus_counts_;
  if (difference < 0) difference += modulus_counts_;
  return difference - half;
}

bool Encoder::plausible(const Reading& from, const Reading& to) const noexcept {
  const std::int64_t travel = signed_difference(to.raw_counts, from.raw_counts);
  const double bound = max_speed_counts_per_ns_ * static_cast<double>(to.t_ns - from.t_ns) + 1;
  return std::abs(static_cast<double>(travel)) <= bound;
}

bool Encoder::far_from(Nanoseconds elapsed_ns) const noexcept {
  const double reach = max_speed_counts_per_ns_ * static_cast<double>(elapsed_ns);
  return elapsed_ns > stale_after_ns_ && 2 * reach >= static_cast<double>(modulus_counts_);
}

void Encoder::anchor(const Reading& reading) noexcept {
  counts_ = signed_difference(reading.raw_counts, calibration_.offset_counts);
  reference_ = reading;
  has_reference_ = true;
  drop_zero();
  velocity_.reset();
  accept(reading);
}

void Encoder::set_zero() noexcept {
  counts_ = 0;
  has_zero_ = has_reference_;
  velocity_.reset();
  q_dot_ = velocity_.update(from_home(), reference_.t_ns);
}

void Encoder::accept(const Reading& reading) noexcept {
  counts_ += signed_difference(reading.raw_counts, reference_.raw_counts);
  reference_ = reading;
  agreeing_ = 0;
  last_was_accepted_ = true;
  ++counters_.accepted;
  vote(false);
  q_dot_ = velocity_.update(from_home(), reading.t_ns);
}

void Encoder::reject(const Reading& reading) noexcept {
  last_was_accepted_ = false;
  ++counters_.implausible;
  vote(true);
  const bool agrees = reading.t_ns > candidate_.t_ns && plausible(candidate_, reading);
  agreeing_ = agrees ? agreeing_ + 1 : 1;  // 1 for the first in either case
  candidate_ = reading;
  if (agreeing_ >= votes_needed) {
    ++counters_.resyncs;
    drop_zero();
    velocity_.reset();
    accept(reading);
  }
}

void Encoder::vote(bool rejected) noexcept {
  constexpr unsigned window_mask = (1u << votes_window) - 1;
  rejected_history_ = ((rejected_history_ << 1) | (rejected ? 1u : 0u)) & window_mask;
}

}  // namespace godobject
