// Compositions without contacts: rigid tools and bodies, articulated tools, long chains.
#include "platform/engine/tool.h"

namespace godobject {

void add_free(std::vector<CompositionRow>& table) {
  // Rigid tools and bodies.
  table.push_back(row<Tool<ImplicitEuler, 1>>("rigid"));
  table.push_back(row<Tool<ImplicitEuler, 8>>("rigid"));
  table.push_back(row<Tool<TrBdf2, 1>>("rigid"));
  table.push_back(row<Tool<TrBdf2, 8>>("rigid"));
  // Articulated tools.
  table.push_back(row<Tool<ImplicitEuler, 8, AllJoints>>("joints"));
  table.push_back(row<Tool<TrBdf2, 8, AllJoints>>("joints"));
  // Long chains of bodies.
  table.push_back(row<Tool<ImplicitEuler, 256, AllJoints>>("joints"));
  table.push_back(row<Tool<TrBdf2, 256, AllJoints>>("joints"));
}

}  // namespace godobject
