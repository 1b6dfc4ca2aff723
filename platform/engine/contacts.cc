// Compositions: a rigid tool in contact with obstacles.
#include "platform/engine/tool.h"

namespace godobject {

void add_contacts(std::vector<CompositionRow>& table) {
  table.push_back(row<Tool<ImplicitEuler, 1, None, ToolContacts>>("contacts"));
  table.push_back(row<Tool<TrBdf2, 1, None, ToolContacts>>("contacts"));
}

}  // namespace godobject
