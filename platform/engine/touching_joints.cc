// Compositions: articulated tools and free bodies in contact with each other and with obstacles.
#include "platform/engine/tool.h"

namespace godobject {

void add_touching_joints(std::vector<CompositionRow>& table) {
  table.push_back(row<Tool<ImplicitEuler, 64, AllJoints, PileContacts>>("joints-touching"));
  table.push_back(row<Tool<TrBdf2, 64, AllJoints, PileContacts>>("joints-touching"));
}

}  // namespace godobject
