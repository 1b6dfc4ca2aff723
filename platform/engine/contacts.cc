// Compositions of tools in contact with obstacles.
#include "platform/engine/tool.h"

namespace godobject {

void add_contacts(std::vector<CompositionRow>& table) {
  // A rigid tool in contact with obstacles.
  table.push_back(row<Tool<ImplicitEuler, 1, None, ToolContacts>>("contacts"));
  table.push_back(row<Tool<TrBdf2, 1, None, ToolContacts>>("contacts"));
  // Articulated tools in contact with obstacles.
  table.push_back(row<Tool<ImplicitEuler, 64, AllJoints, ToolContacts>>("joints-contacts"));
  table.push_back(row<Tool<TrBdf2, 64, AllJoints, ToolContacts>>("joints-contacts"));
}

}  // namespace godobject
