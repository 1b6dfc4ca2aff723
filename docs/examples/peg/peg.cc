// README's Peg without a device: the target moves 1 cm aside within 0.1 s.
#include "peg.h"

#include <cstdio>

int main() {
  if (!set_up({})) return 2;
  for (int i = 1; i <= 1000; ++i) {
    const bool moves = i <= 100;
    in.devices[0].target.X_WD.p.x() = moves ? 1e-4 * i : 1e-2;
    in.devices[0].target.V_WD.v.x() = moves ? 0.1 : 0;
    step(par, in, x, w, out);
    if (out.fault != Fault::none) return 1;
  }
  const double off_mm = 1e3 * (x.bodies[0].x.X_WB.p - in.devices[0].target.X_WD.p).norm();
  std::printf("off the target after 1 s: %.6f mm; force shown %.6f N\n", off_mm,
              out.bodies[0].feedback.F_D.f.norm());
  return off_mm < 1e-3 ? 0 : 1;
}
