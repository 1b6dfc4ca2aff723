// Promises of sim/fault/promise.h, injected on test::FaultyRig.
#pragma once

#include <cmath>
#include <ostream>
#include <string>
#include <vector>

#include "sim/fault/promise.h"

namespace godobject::test {

/// From the fault of a drive that receives nothing to its own watchdog, plus one cycle on either side.
inline constexpr int cycles_of_watchdog = 22;
/// stale_after and lost_after are 3 and 100 cycles.
inline constexpr int cycles_of_loss = 108;
/// Cycles in which a joint of FaultyRig moves by its max_slip, at any phase of its motion.
inline constexpr int cycles_of_travel = 500;

inline void replace(std::string& text, const std::string& word, const std::string& by) {
  if (const std::size_t at = text.find(word); at != std::string::npos) text.replace(at, word.size(), by);
}

/// Returns the words of a promise for a rig with encoders 1 and 2 and the emergency stop 3 on can0,
/// and drives 1 and 2 on can1.
inline std::string words_for(const FaultPromise& promise, const RigParams& rig) {
  std::string words(promise.words);
  replace(words, "ENCODER", "bus=can0 node=1");
  replace(words, "DRIVE", "bus=can1 node=1");
  replace(words, "STOP", "bus=can0 node=3");
  replace(words, "OTHER", "2");
  for (const auto& [name, time_s] :
       {std::pair{"*stale_after", rig.stale_after_s}, std::pair{"*lost_after", rig.lost_after_s}}) {
    if (words.find(name) == std::string::npos) continue;
    const std::size_t begin = words.find("value=") + 6;
    return words.substr(0, begin) + std::to_string(std::stod(words.substr(begin)) * time_s);
  }
  return words;
}

struct FaultReaction {
  std::string words;
  RigFault expected = RigFault::none;  // at least one of its bits; none: no fault may be raised
  int within = 0;                      // cycles until the first
  MotorsEnd motors = MotorsEnd::keep;
};

inline std::ostream& operator<<(std::ostream& out, const FaultReaction& reaction) {
  return out << reaction.words;
}

inline std::vector<FaultReaction> fault_reactions(const RigParams& rig, double cycle_s) {
  std::vector<FaultReaction> out;
  for (const FaultPromise& promise : fault_promises()) {
    FaultReaction reaction{.words = words_for(promise, rig), .motors = promise.motors};
    for (const PromisedFault& promised : promise.faults) {
      // a fault that needs travel may be preceded by one that does not
      const bool may_be_first = promised.always || promised.fault == RigFault::send_refused ||
                                promise.faults[0].within == FaultDelay::travel;
      if (promised.fault == RigFault::none || !may_be_first) continue;
      reaction.expected = reaction.expected | promised.fault;
      if (promised.within == FaultDelay::duration) continue;  // never the first
      const auto within_ns = bound(promised.within, rig, cycle_s, 0);
      const int within = within_ns
                             ? static_cast<int>(std::lround(1e-9 * static_cast<double>(*within_ns) / cycle_s))
                             : cycles_of_travel;
      if (reaction.within == 0 || (promised.always && within < reaction.within)) reaction.within = within;
    }
    out.push_back(reaction);
  }
  return out;
}

}  // namespace godobject::test
