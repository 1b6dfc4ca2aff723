// Compositions: rigid tools and bodies without joints and contacts.
#include "platform/engine/tool.h"

namespace godobject {

void add_rigid(std::vector<CompositionRow>& table) {
  table.push_back(row<Tool<ImplicitEuler, 1>>("rigid"));
  table.push_back(row<Tool<ImplicitEuler, 8>>("rigid"));
  table.push_back(row<Tool<TrBdf2, 1>>("rigid"));
  table.push_back(row<Tool<TrBdf2, 8>>("rigid"));
}

}  // namespace godobject
