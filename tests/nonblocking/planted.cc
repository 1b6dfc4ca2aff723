// A step that blocks, with the call that PLANTED names; without it, a step that does not.
#include <cstdlib>
#include <mutex>

#include "core/godobject.h"

namespace godobject {

/// A part of a scene, as a user writes it.
struct PlantedFeedback : LimitedFeedback {
  static Wrench wrench(const SpringParams& par, const RigidBodyState& body, const Target& to,
                       const Vec3& phi_B) noexcept {
#if defined(PLANT_MALLOC)
    free(malloc(sizeof(Wrench)));
#elif defined(PLANT_NEW)
    delete new Wrench;
#elif defined(PLANT_LOCK)
    static_cast<void>(std::scoped_lock(mutex));
#elif defined(PLANT_THROW)
    if (!(phi_B.norm() <= pi)) throw phi_B;
#endif
    return LimitedFeedback::wrench(par, body, to, phi_B);
  }
  static inline std::mutex mutex;
};

struct PlantedScene {
  static constexpr std::size_t max_bodies = 1;
  using Integrator = ImplicitEuler;
  using Device = PoseDevice;
  using Joints = None;
  using Coupling = DampedSpring;
  using Feedback = PlantedFeedback;
};

void run(const Params<PlantedScene>& par, const Input<PlantedScene>& in, State<PlantedScene>& x,
         Scratch<PlantedScene>& w, Output<PlantedScene>& out) noexcept {
  step(par, in, x, w, out);
}

}  // namespace godobject
