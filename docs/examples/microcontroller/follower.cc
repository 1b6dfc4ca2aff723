// The smallest firmware: one rigid tool follows the pose of a device, without force feedback.
#include "scenes.h"

namespace {

using namespace scenes;

Params<Follower> par;
State<Follower> x;
Input<Follower> in;
Output<Follower> out;

}  // namespace

int main() {
  // Mass and inertia are constant, and so is the root of the largest ratio of moments (rigid_body()).
  par.bodies[0].body.m = 0.1;
  par.bodies[0].body.I_B = Vec3(3.4667e-4, 3.4667e-4, 2.6667e-5).asDiagonal();
  par.bodies[0].body.anisotropy = 3.60553;
  par.bodies[0].coupling = {.k = 1000, .g = 14, .k_r = 1, .g_r = 2.606670758728e-2};
  place(x, 0, {});
  for (int i = 0; i < 1000; ++i) {
    // An interrupt of the device writes `in`.
    asm volatile("" ::: "memory");
    Scratch<Follower> w;  // on the stack, because nothing in it lasts
    step(par, in, x, w, out);
    if (out.fault != Fault::none) return 1;
  }
  return 0;
}
