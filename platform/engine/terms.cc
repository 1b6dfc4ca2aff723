// Compositions with springs, gears, closing joints and constant forces, in contact with anything.
#include "platform/engine/tool.h"

namespace godobject {
namespace {

template <class I>
struct Sprung : Tool<I, 64, AllJoints, PileContacts> {
  using Terms = ToolTerms;
};

}  // namespace

void add_terms(std::vector<CompositionRow>& table) {
  table.push_back(row<Sprung<ImplicitEuler>>("terms"));
  table.push_back(row<Sprung<TrBdf2>>("terms"));
}

}  // namespace godobject
