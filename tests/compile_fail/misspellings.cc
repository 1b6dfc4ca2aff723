// Must compile: each of these scenes would lack the misspelt part, and is refused.
#include "core/godobject.h"

using namespace godobject;

struct Free {
  static constexpr int max_bodies = 1;
  using Integrator = TrBdf2;
  using Device = None;
  using Coupling = None;
  using Joints = None;
  using Feedback = None;
};
static_assert(Scene<Free>);

#define REFUSED(name)                      \
  struct With_##name : Free {              \
    using name = FixedContacts<10, 1, 20>; \
  };                                       \
  static_assert(!Scene<With_##name>);
REFUSED(ontacts)
REFUSED(Cntacts)
REFUSED(Cotacts)
REFUSED(Conacts)
REFUSED(Contcts)
REFUSED(Contats)
REFUSED(Contacs)
REFUSED(Contact)
REFUSED(CContacts)
REFUSED(Coontacts)
REFUSED(Conntacts)
REFUSED(Conttacts)
REFUSED(Contaacts)
REFUSED(Contaccts)
REFUSED(Contactts)
REFUSED(Contactss)
REFUSED(oCntacts)
REFUSED(Cnotacts)
REFUSED(Cotnacts)
REFUSED(Conatcts)
REFUSED(Contcats)
REFUSED(Contatcs)
REFUSED(Contacst)
REFUSED(contacts)
REFUSED(CONTACTS)
REFUSED(Contacts_)
REFUSED(contact)
REFUSED(Contact_)
REFUSED(Contract)
REFUSED(Contracts)
REFUSED(Contakts)
REFUSED(Collision)
REFUSED(Collisions)
REFUSED(ContactList)
REFUSED(FixedContact)
REFUSED(BodyContact)

REFUSED(erms)
REFUSED(Trms)
REFUSED(Tems)
REFUSED(Ters)
REFUSED(Term)
REFUSED(TTerms)
REFUSED(Teerms)
REFUSED(Terrms)
REFUSED(Termms)
REFUSED(Termss)
REFUSED(eTrms)
REFUSED(Trems)
REFUSED(Temrs)
REFUSED(Tersm)
REFUSED(terms)
REFUSED(TERMS)
REFUSED(Terms_)
REFUSED(term)
REFUSED(Spring)
REFUSED(Springs)
REFUSED(et)
REFUSED(Nt)
REFUSED(Ne)
REFUSED(NNet)
REFUSED(Neet)
REFUSED(Nett)
REFUSED(eNt) REFUSED(Nte) REFUSED(net) REFUSED(NET) REFUSED(Net_) REFUSED(Nets) REFUSED(nets) REFUSED(Mesh)
