// Compositions: long chains of bodies.
#include "platform/engine/tool.h"

namespace godobject {

void add_chains(std::vector<CompositionRow>& table) {
  table.push_back(row<Tool<ImplicitEuler, 256, AllJoints>>("joints"));
  table.push_back(row<Tool<TrBdf2, 256, AllJoints>>("joints"));
}

}  // namespace godobject
