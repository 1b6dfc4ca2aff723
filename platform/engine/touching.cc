// Compositions: many bodies in contact with each other and with obstacles.
#include "platform/engine/tool.h"

namespace godobject {

void add_touching(std::vector<CompositionRow>& table) {
  table.push_back(row<Tool<ImplicitEuler, 64, None, PileContacts>>("touching"));
  table.push_back(row<Tool<TrBdf2, 64, None, PileContacts>>("touching"));
}

}  // namespace godobject
