// How many periods late a node's answers to SYNC are. One object per encoder or drive.
#pragma once

#include <algorithm>
#include <cstdint>

#include "hal/can/frame.h"

namespace godobject {

/// Measures the delay of a stream of answers by a mark in it: a SYNC that the host leaves out.
///
/// Answers look alike, so a receive stamp cannot tell the answer to this SYNC from a late one to an earlier SYNC. The
/// node does not answer a SYNC that was left out. The number of cycles from that SYNC to the cycle in which an answer
/// is missing is the delay in periods. A missing answer that no mark explains puts the delay in doubt: the frame was
/// lost, or the delay has grown. An answer too many puts a delay in doubt that may have shrunk.
///
/// Two marks in a row must agree before a delay is believed. A lost frame near a mark looks like the mark; the mark
/// itself then is a missing answer without explanation, which leads to the next measurement.
class AnswerDelay {
 public:
  /// every_nth: of the SYNCs that the node answers. reach: greatest delay that is measured, periods.
  AnswerDelay(std::uint64_t every_nth, std::uint64_t reach) noexcept : every_nth_(every_nth), reach_(reach) {}

  /// sync: number of the SYNC that is left out.
  void left_out(std::uint64_t sync) noexcept { mark_ = sync; }

  /// Takes an answer. sync: number of the last SYNC, also of one left out, before the answer began; greater than that
  /// of the answer before. last_sync: number of the last SYNC at time `now`, ns.
  void answered(std::uint64_t sync, std::uint64_t last_sync, Nanoseconds now) noexcept {
    const std::uint64_t due = last_ + every_nth_;
    if (last_ != 0) compare(sync, due);
    last_ = sync;
    last_read_ = last_sync;
    if (!in_doubt_) t_known_ns_ = now;
  }

  /// Takes a further answer in the same cycle.
  void answered_again() noexcept { in_doubt_ = in_doubt_ || periods_ > 0; }

  /// Delay that is believed, periods; reach + 1: more than reach.
  std::uint64_t periods() const noexcept { return periods_; }
  bool beyond_reach() const noexcept { return periods_ > reach_; }
  /// True until a mark has shown the delay, and after any answer that has changed it or was lost.
  bool in_doubt() const noexcept { return in_doubt_; }
  /// True if a mark now would be seen: answers are coming, and the delay is in doubt.
  bool wants_mark(std::uint64_t last_sync) const noexcept {
    return in_doubt_ && last_ != 0 && last_sync - last_read_ < every_nth_;
  }
  /// Time of the last answer whose delay was known, ns; 0: none yet.
  Nanoseconds t_known_ns() const noexcept { return t_known_ns_; }
  /// Periods from a mark to the end of its measurement, at most.
  std::uint64_t longest() const noexcept { return reach_ + every_nth_ + 1; }

 private:
  // Answers to every n-th SYNC are a period later after a mark: one cycle is missing. The cycle that was due n before
  // `due` had its answer.
  void compare(std::uint64_t sync, std::uint64_t due) noexcept {
    std::uint64_t missing = sync > due ? sync - due : 0;
    const bool is_marked = mark_ != 0 && sync > mark_;
    if (sync < due) answered_again();
    if (is_marked && missing > 0) {
      const std::uint64_t shown = mark_ + every_nth_ - 1;
      measured(due > shown ? due - shown : 0);
      --missing;
    } else if (mark_ != 0 && due >= mark_ + reach_ && sync == due) {
      measured(reach_ + 1);
    }
    if (missing > 0) in_doubt_ = true;
  }

  void measured(std::uint64_t periods) noexcept {
    const std::uint64_t shorter = std::min(periods, measured_), longer = std::max(periods, measured_);
    const bool agrees = longer - shorter < every_nth_;
    measured_ = periods;
    mark_ = 0;
    if (agrees) periods_ = shorter;
    in_doubt_ = !agrees || beyond_reach();
  }

  std::uint64_t every_nth_, reach_;
  std::uint64_t last_ = 0,
                last_read_ = 0;  // number of the last answer's SYNC, and of the SYNC when it was read
  std::uint64_t mark_ = 0;       // number of the SYNC left out that is looked for; 0: none
  std::uint64_t measured_ = 0, periods_ = 0;
  bool in_doubt_ = true;
  Nanoseconds t_known_ns_ = 0;
};

}  // namespace godobject
