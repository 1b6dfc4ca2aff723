// Compositions of bodies that touch each other: rigid, articulated, and with nets.
#include "platform/engine/tool.h"

namespace godobject {
namespace {

template <class I>
struct Nets : Tool<I, 16, AllJoints, NetContacts> {
  using Net =
      MassSpringNet<max_net_nodes, max_net_springs, max_net_contacts, max_net_attachments, max_net_faces>;
};

}  // namespace

void add_many(std::vector<CompositionRow>& table) {
  // Many bodies in contact with each other and with obstacles.
  table.push_back(row<Tool<ImplicitEuler, 64, None, PileContacts>>("touching"));
  table.push_back(row<Tool<TrBdf2, 64, None, PileContacts>>("touching"));
  // Articulated tools and free bodies in contact with each other and with obstacles.
  table.push_back(row<Tool<ImplicitEuler, 64, AllJoints, PileContacts>>("joints-touching"));
  table.push_back(row<Tool<TrBdf2, 64, AllJoints, PileContacts>>("joints-touching"));
  // Deformable nets on tools and free bodies, with contacts among all of them and with obstacles.
  table.push_back(row<Nets<ImplicitEuler>>("nets"));
  table.push_back(row<Nets<TrBdf2>>("nets"));
}

}  // namespace godobject
