// Compositions of a quick study and of the tests: quick_probes of tests/study/CMakeLists.txt.
#include "tests/study/probe/probe.h"

namespace godobject::study {

std::vector<Probe> probes() {
  return {probe<Free<ImplicitEuler, 1>>("free"),
          probe<Free<TrBdf2, 1>>("free"),
          probe<DeviceOnly<TrBdf2, 1>>("device"),
          probe<Follower<ImplicitEuler, 1>>("pose"),
          probe<Follower<TrBdf2, 1>>("pose"),
          probe<Haptic<TrBdf2, 1>>("haptic"),
          probe<FreeJoints<TrBdf2, 8>>("free-joints"),
          probe<Tool<ImplicitEuler, 4>>("pose-joints"),
          probe<Tool<TrBdf2, 4>>("pose-joints"),
          size_of<Follower<ImplicitEuler, 64>>("bricks"),
          size_of<Bricks<ImplicitEuler, 64>>("bricks-contacts")};
}

}  // namespace godobject::study
