// Compositions of tests/study/CMakeLists.txt.
#include "tests/study/probe/probe.h"

namespace godobject::study {
namespace {

/// Adds a scene type with both integrators.
template <template <class, std::size_t> class SceneOf, std::size_t... capacities>
void add(std::vector<Probe>& probes, const std::string& scene) {
  (probes.push_back(probe<SceneOf<ImplicitEuler, capacities>>(scene)), ...);
  (probes.push_back(probe<SceneOf<TrBdf2, capacities>>(scene)), ...);
}

}  // namespace

std::vector<Probe> probes() {
  std::vector<Probe> all;
  add<Free, 1, 8>(all, "free");
  add<DeviceOnly, 1, 8>(all, "device");
  add<Follower, 1, 8>(all, "pose");
  add<Haptic, 1, 8>(all, "haptic");
  add<Relative, 1, 8>(all, "relative");
  add<Admittance, 1, 8>(all, "admittance");
  add<FreeJoints, 1, 8, 64, 256>(all, "free-joints");
  add<Tool, 2, 4>(all, "pose-joints");
  add<ToolWithStops, 4>(all, "pose-joints-stops");
  add<ToolWithImposed, 4>(all, "pose-joints-imposed");
  add<ToolWithAll, 4>(all, "pose-joints-stops-imposed");
  add<Tool, 1>(all, "pressed");
  add<PressedTool, 1>(all, "pressed-contacts");
  all.push_back(probe<Follower<ImplicitEuler, 64>>("bricks"));
  all.push_back(probe<Bricks<ImplicitEuler, 64>>("bricks-contacts"));
  add<NetTool, 1024>(all, "net-tool");
  return all;
}

}  // namespace godobject::study
