// Compositions: articulated tools.
#include "platform/engine/tool.h"

namespace godobject {

void add_joints(std::vector<CompositionRow>& table) {
  table.push_back(row<Tool<ImplicitEuler, 8, AllJoints>>("joints"));
  table.push_back(row<Tool<TrBdf2, 8, AllJoints>>("joints"));
}

}  // namespace godobject
