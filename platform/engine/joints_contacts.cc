// Compositions: articulated tools in contact with obstacles.
#include "platform/engine/tool.h"

namespace godobject {

void add_joints_contacts(std::vector<CompositionRow>& table) {
  table.push_back(row<Tool<ImplicitEuler, 64, AllJoints, ToolContacts>>("joints-contacts"));
  table.push_back(row<Tool<TrBdf2, 64, AllJoints, ToolContacts>>("joints-contacts"));
}

}  // namespace godobject
