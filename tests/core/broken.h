// A solver with a deliberate error: velocities and angular velocities grow a little in each step.
#pragma once

#include "core/godobject.h"

namespace godobject {

template <class I, int per_million>
struct Broken : I {
  template <Scene S>
  static Limited advance(const Params<S>& par, const State<S>& x, Scratch<S>& w) noexcept {
    const Limited limited = I::advance(par, x, w);
    for (std::size_t g = 0; g < num_groups(par); ++g) {
      w.next[g].x.v_W *= Real(1 + per_million * 1e-6);
      w.next[g].x.w_B *= Real(1 + per_million * 1e-6);
    }
    return limited;
  }
};

}  // namespace godobject
