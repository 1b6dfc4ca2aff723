// Compositions of tools in contact with obstacles, and of articulated tools that touch free bodies too.
#include "platform/engine/tool.h"

namespace godobject {

void add_contacts(std::vector<CompositionRow>& table) {
  // A rigid tool in contact with obstacles.
  table.push_back(row<Tool<ImplicitEuler, 1, None, ToolContacts>>("contacts"));
  table.push_back(row<Tool<TrBdf2, 1, None, ToolContacts>>("contacts"));
  // Articulated tools in contact with obstacles.
  table.push_back(row<Tool<ImplicitEuler, 64, AllJoints, ToolContacts>>("joints-contacts"));
  table.push_back(row<Tool<TrBdf2, 64, AllJoints, ToolContacts>>("joints-contacts"));
  // Articulated tools and free bodies in contact with each other and with obstacles.
  table.push_back(row<Tool<ImplicitEuler, 64, AllJoints, PileContacts>>("joints-touching"));
  table.push_back(row<Tool<TrBdf2, 64, AllJoints, PileContacts>>("joints-touching"));
}

}  // namespace godobject
