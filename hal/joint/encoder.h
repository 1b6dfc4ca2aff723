// One joint sensor: raw counts and their times in; joint coordinate with validity, time and age out.
#pragma once

#include <cstdint>

#include "hal/base/nanoseconds.h"
#include "hal/joint/params.h"
#include "hal/joint/velocity_estimator.h"

namespace godobject {

/// Output of a joint sensor. While `valid` is false, q and q_dot are those of the last good sample; q_dot of
/// a stale sample is 0.
struct JointSample {
  double q = 0;      // rad or m
  double q_dot = 0;  // rad/s or m/s
  bool valid = false;
  Nanoseconds t_ns = 0;  // sampling time of q

  Nanoseconds age(Nanoseconds now) const noexcept { return now - t_ns; }
};

struct EncoderCounters {
  std::uint64_t accepted = 0;
  std::uint64_t implausible = 0;   // implied a speed above max_speed, or counts outside the modulus
  std::uint64_t out_of_order = 0;  // not later than the previous sample: ignored
  std::uint64_t resyncs = 0;       // reference dropped after a jump or a long gap
};

/// Unwraps, scales, checks and differentiates the counts of one joint.
///
/// Plausibility. A sample is rejected (not valid, counted) if the travel since the last *accepted* one
/// exceeds max_speed times the elapsed time, plus one count. Missing or rejected samples thus widen the
/// bound: a true fast motion is never locked out. A single spike invalidates one cycle only. If
/// `votes_needed` of the last `votes_window` samples were rejected, the sensor is no longer `trusted()`, and
/// the rig reports a fault. If `votes_needed` consecutive samples are rejected but agree with each other, the
/// joint has moved there: the sensor was reset, or counts were lost. They then become the new reference and
/// velocity restarts.
///
/// Turns. The first sample selects the turn with q nearest to home. So does a sample after a gap in which the
/// joint could have moved half the modulus. In between, turns are tracked.
///
/// Zero. That of an incremental sensor is unknown until set_zero(). A new reference drops it, because counts
/// are then no longer continuous. Samples without a zero are not valid.
class Encoder {
 public:
  static constexpr int votes_needed = 3;
  static constexpr int votes_window = 5;

  /// max_speed: rad/s or m/s. stale_after_ns: age above which a sample is not valid, ns.
  Encoder(const Calibration& calibration, double max_speed, Nanoseconds stale_after_ns) noexcept;

  /// Adds a sample. raw_counts: as on the wire (two's complement if signed). t_ns: sampling time, ns.
  void update(std::uint32_t raw_counts, Nanoseconds t_ns) noexcept;

  /// Returns the latest good sample; valid if good() and the zero is known.
  JointSample sample(Nanoseconds now) const noexcept;

  /// Sets the zero of an incremental sensor: the coordinate of the last good sample becomes home.
  void set_zero() noexcept;
  /// Drops the zero of an incremental sensor; no effect on an absolute one.
  void drop_zero() noexcept { has_zero_ = !calibration_.incremental; }
  bool has_zero() const noexcept { return has_zero_; }
  bool is_incremental() const noexcept { return calibration_.incremental; }

  bool has_sample() const noexcept { return has_reference_; }
  /// True if the latest update was accepted and is not stale. Its coordinate may lack a zero.
  bool good(Nanoseconds now) const noexcept { return last_was_accepted_ && !stale(now); }
  /// True if the last good sample is older than stale_after, or there is none.
  bool stale(Nanoseconds now) const noexcept;
  /// True if the joint could have moved half the modulus since the last good sample; its turn is then
  /// unknown.
  bool turn_is_lost(Nanoseconds now) const noexcept {
    return has_reference_ && far_from(now - reference_.t_ns);
  }
  bool trusted() const noexcept;
  const EncoderCounters& counters() const noexcept { return counters_; }

 private:
  struct Reading {
    std::uint32_t raw_counts = 0;
    Nanoseconds t_ns = 0;
  };

  double from_home() const noexcept;
  std::int64_t signed_difference(std::int64_t to, std::int64_t from) const noexcept;
  bool plausible(const Reading& from, const Reading& to) const noexcept;
  bool far_from(Nanoseconds elapsed_ns) const noexcept;
  void anchor(const Reading& reading) noexcept;
  void accept(const Reading& reading) noexcept;
  void reject(const Reading& reading) noexcept;
  void vote(bool rejected) noexcept;

  Calibration calibration_;
  std::int64_t modulus_counts_;
  double max_speed_counts_per_ns_;
  Nanoseconds stale_after_ns_;
  VelocityEstimator velocity_;

  Reading reference_;        // last accepted
  std::int64_t counts_ = 0;  // unwrapped, relative to the calibration's offset
  double q_dot_ = 0;
  bool has_reference_ = false;
  bool has_zero_;
  bool last_was_accepted_ = false;
  Reading candidate_;              // last rejected
  int agreeing_ = 0;               // number of consecutive rejected samples that agree with each other
  unsigned rejected_history_ = 0;  // bit 0: the latest sample
  EncoderCounters counters_;
};

}  // namespace godobject
