// One joint sensor: raw counts and their times in, joint coordinate with validity, time and age out.
//
// The room: velocity_estimator.h, slip.h (encoder against drive), sync_attribution.h (which SYNC a frame answers),
// answer_delay.h (how late a node answers), kinematic_tree.h from joints to handles and back, inverse_kinematics.h.
#pragma once

#include <cstdint>

#include "hal/can/frame.h"
#include "hal/joint/velocity_estimator.h"
#include "hal/rig/params.h"

namespace godobject {

/// What a joint sensor says. While `valid` is false, q and q_dot are those of the last good sample,
/// except that the q_dot of a stale one is 0.
struct JointSample {
  double q = 0;      // rad or m
  double q_dot = 0;  // rad/s or m/s
  bool valid = false;
  Nanoseconds t_ns = 0;  // when q was measured

  Nanoseconds age(Nanoseconds now) const noexcept { return now - t_ns; }
};

struct EncoderCounters {
  std::uint64_t accepted = 0;
  std::uint64_t implausible = 0;   // implied a speed above max_speed, or counts outside the modulus
  std::uint64_t out_of_order = 0;  // not later than the sample before: ignored
  std::uint64_t resyncs = 0;       // reference given up after a jump or a long gap
};

/// Unwraps, scales, checks and differentiates the counts of one joint.
///
/// Plausibility. A sample is rejected (not valid, counted) when the travel since the last *accepted*
/// one exceeds max_speed times the time that has really passed, plus one count. Missing or rejected
/// samples thus widen the bound: a true fast motion is never locked out. One spike makes one cycle
/// invalid and nothing else. When `votes_needed` of the last `votes_window` samples were rejected the
/// sensor is no longer `trusted()`; that is the fault the rig reports. When `votes_needed` samples in
/// a row are rejected but agree with each other, the joint really is there (the sensor was re-set,
/// counts were lost): they become the new reference and velocity restarts.
///
/// Turns. At the first sample, and after a gap in which the joint could have travelled half the
/// modulus, the turn is the one that brings q nearest to home. In between, turns are followed.
class Encoder {
 public:
  static constexpr int votes_needed = 3;
  static constexpr int votes_window = 5;

  /// max_speed: rad/s or m/s. stale_after_ns: a sample older than this is not valid.
  Encoder(const Calibration& calibration, double max_speed, Nanoseconds stale_after_ns) noexcept;

  /// raw_counts as on the wire (two's complement where signed), measured at t_ns.
  void update(std::uint32_t raw_counts, Nanoseconds t_ns) noexcept;

  /// The latest good sample; valid if the latest update was accepted and it is not stale.
  JointSample sample(Nanoseconds now) const noexcept;

  bool has_sample() const noexcept { return has_reference_; }
  /// No good sample for longer than stale_after (or none ever).
  bool stale(Nanoseconds now) const noexcept;
  /// Since the last good sample the joint could have travelled half the modulus: its turn will not be known.
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
  std::int64_t counts_ = 0;  // unwrapped, from the calibration's offset
  double q_dot_ = 0;
  bool has_reference_ = false;
  bool last_was_accepted_ = false;
  Reading candidate_;              // last rejected
  int agreeing_ = 0;               // rejected samples in a row that agree with each other
  unsigned rejected_history_ = 0;  // bit 0: the latest sample
  EncoderCounters counters_;
};

}  // namespace godobject
