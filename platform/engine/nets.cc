// Compositions: deformable nets on tools and free bodies, with contacts among all of them and with obstacles.
#include "platform/engine/tool.h"

namespace godobject {
namespace {

template <class I>
struct Nets : Tool<I, 16, AllJoints, NetContacts> {
  using Net = MassSpringNet<max_net_nodes, max_net_springs, max_net_contacts, max_net_attachments>;
};

}  // namespace

void add_nets(std::vector<CompositionRow>& table) {
  table.push_back(row<Nets<ImplicitEuler>>("nets"));
  table.push_back(row<Nets<TrBdf2>>("nets"));
}

}  // namespace godobject
