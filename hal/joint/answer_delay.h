// Delay of a node's answers to SYNC, in periods. One object per encoder or drive.
#pragma once

#include <algorithm>
#include <cstdint>

#include "hal/base/nanoseconds.h"

namespace godobject {

/// Measures the delay of a stream of answers by a mark in it: a SYNC that the host leaves out.
///
/// Answers look alike, so a receive stamp cannot separate the answer to this SYNC from a late one to an
/// earlier SYNC. The node does not answer a SYNC that was left out. The number of cycles from that SYNC to
/// the cycle in which an answer is missing is the delay in periods. A missing answer that no mark explains
/// puts the delay in doubt: the frame was lost, or the delay has grown. A surplus answer does so, too: the
/// delay may have shrunk.
///
/// A lost frame near a mark looks like the mark. So a delay is accepted if two marks in a row agree, and one
/// beyond reach after three. If a lost frame was taken for the mark, the missing answer of the mark itself is
/// unexplained and causes the next measurement. Two answers in one cycle are jitter and can fill the cycle of
/// a mark. Near them, no longer delay is accepted.
class AnswerDelay {
 public:
  /// SYNCs between two marks, at least; for so long two answers in one cycle count as jitter.
  static constexpr std::uint64_t min_distance = 16;
  /// Marks in a row that must not be seen within reach before a delay beyond it is accepted.
  static constexpr int needed_beyond = 3;

  /// every_nth: the node answers at least every n-th SYNC. reach: greatest delay that is measured, periods.
  AnswerDelay(std::uint64_t every_nth, std::uint64_t reach) noexcept : every_nth_(every_nth), reach_(reach) {}

  /// Records a mark. A node without two answers so far cannot show it. sync: number of the SYNC that is left
  /// out at time `now`, ns.
  void left_out(std::uint64_t sync, Nanoseconds now) noexcept {
    if (distance_ == 0) return;
    mark_ = sync;
    t_mark_ns_ = now;
  }

  /// Records an answer. sync: number of the last SYNC, also of one left out, before the answer began; greater
  /// than that of the previous answer. last_sync: number of the last SYNC now.
  void answered(std::uint64_t sync, std::uint64_t last_sync) noexcept {
    if (distance_ != 0) compare(sync, last_ + distance_);
    if (last_ != 0) {
      const std::uint64_t gap = std::min(sync - last_, every_nth_);
      distance_ = std::min(gap, gap_);
      gap_ = gap;
    }
    last_ = sync;
    last_read_ = last_sync;
  }

  /// Records a further answer in the same cycle.
  void answered_again() noexcept {
    jittered_ = last_;
    in_doubt_ = in_doubt_ || periods_ > 0;
  }

  /// Accepted delay, periods; reach + 1: more than reach.
  std::uint64_t periods() const noexcept { return periods_; }
  bool beyond_reach() const noexcept { return periods_ > reach_; }
  /// True while the last mark is awaited in the answers.
  bool is_pending() const noexcept { return mark_ != 0; }
  /// True until the delay is measured, and again after a missing or surplus answer.
  bool in_doubt() const noexcept { return in_doubt_; }
  /// True once it has been measured.
  bool is_measured() const noexcept { return is_measured_; }
  /// True if the delay is in doubt and a mark now would be seen. The latter holds if the last due answer
  /// came.
  bool needs_mark(std::uint64_t last_sync) const noexcept {
    return in_doubt_ && distance_ != 0 && last_sync - last_read_ < every_nth_;
  }
  /// Time of the first mark that has shown a delay beyond reach, ns.
  Nanoseconds t_beyond_ns() const noexcept { return t_beyond_ns_; }
  /// Number of marks in a row that have not ended the doubt.
  std::uint64_t num_inconclusive() const noexcept { return num_inconclusive_; }
  /// Periods from a mark to the end of its measurement, at most.
  std::uint64_t longest() const noexcept { return reach_ + every_nth_ + 1; }

 private:
  // Compares an answer with the SYNC to which it was due. A mark explains one missing cycle after it.
  void compare(std::uint64_t sync, std::uint64_t due) noexcept {
    std::uint64_t missing = sync > due ? sync - due : 0;
    const bool is_marked = mark_ != 0 && sync > mark_;
    if (sync < due) answered_again();
    if (is_marked && missing > 0) {
      const std::uint64_t shown = mark_ + distance_ - 1;
      measured(due > shown ? due - shown : 0);
      --missing;
    } else if (mark_ != 0 && due >= mark_ + reach_ && sync == due) {
      not_seen();
    }
    if (missing > 0) in_doubt_ = true;
  }

  // Jitter can make a delay look longer, not shorter.
  void measured(std::uint64_t periods) noexcept {
    if (is_jittered() && periods > periods_) {
      is_measured_ = true;
      return conclude(periods_, false);
    }
    const std::uint64_t shorter = std::min(periods, measured_), longer = std::max(periods, measured_);
    const bool agrees = longer <= reach_ && longer - shorter < every_nth_;
    if (agrees || (longer <= reach_ && beyond_reach())) periods_ = shorter;
    conclude(periods, agrees);
  }

  void not_seen() noexcept {
    if (is_jittered()) return conclude(measured_, false);
    const std::uint64_t beyond = reach_ + 1;
    if (measured_ != beyond) {
      t_beyond_ns_ = t_mark_ns_;
      num_beyond_ = 0;
    }
    if (++num_beyond_ >= needed_beyond) periods_ = beyond;
    conclude(beyond, false);
  }

  bool is_jittered() const noexcept { return jittered_ != 0 && jittered_ + min_distance > mark_; }

  void conclude(std::uint64_t periods, bool is_conclusive) noexcept {
    measured_ = periods;
    mark_ = 0;
    in_doubt_ = !is_conclusive;
    is_measured_ = is_measured_ || is_conclusive;
    num_inconclusive_ = is_conclusive ? 0 : num_inconclusive_ + 1;
  }

  std::uint64_t every_nth_, reach_;
  std::uint64_t gap_ = every_nth_;  // between the last two answers, SYNCs
  std::uint64_t distance_ = 0;      // the smaller of the last two gaps; 0: there are no two answers yet
  std::uint64_t last_ = 0;          // number of the last answer's SYNC
  std::uint64_t last_read_ = 0;     // number of the last SYNC when it was read
  std::uint64_t mark_ = 0;          // number of the left-out SYNC whose missing answer is expected; 0: none
  std::uint64_t measured_ = 0, periods_ = 0;
  bool in_doubt_ = true, is_measured_ = false;
  std::uint64_t jittered_ = 0;  // number of the last SYNC in whose cycle two answers came; 0: none
  std::uint64_t num_inconclusive_ = 0;
  int num_beyond_ = 0;  // marks in a row that were not seen within reach
  Nanoseconds t_mark_ns_ = 0, t_beyond_ns_ = 0;
};

}  // namespace godobject
