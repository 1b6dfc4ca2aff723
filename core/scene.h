// A scene is a type that lists its parts. Parts that it does not list have no storage and no code.
//
//   struct Peg {
//     static constexpr int max_bodies = 1;
//     using Integrator = TrBdf2;         // or ImplicitEuler
//     using Device = PoseDevice;         // or RelativeDevice, AdmittanceDevice; None: free bodies
//     using Joints = None;               // or TreeJoints<>
//     using Coupling = DampedSpring;     // or None
//     using Feedback = LimitedFeedback;  // or None: not haptic
//     using Contacts = FixedContacts<10, 1, 20>;  // or BodyContacts; optional, default: no contacts
//     using Terms = TermList<DampedSprings<40>>;  // other forces; optional
//     using Net = MassSpringNet<1000, 3000, 300>;  // deformable bodies; needs BodyContacts; optional
//   };
//   static_assert(Scene<Peg>);
#pragma once

#include <array>
#include <concepts>
#include <cstdint>
#include <type_traits>

#include "core/body/node.h"
#include "core/body/rigid_body.h"
#include "core/composition.h"
#include "core/contact/forces.h"
#include "core/contact/memory.h"
#include "core/fault.h"
#include "core/net/net.h"

namespace godobject {

template <class P> concept Part = requires {
  typename P::Params;
  typename P::State;
};

// Rules of a scene, one named concept per line: the compiler prints the name of the violated rule.
template <class S> concept HasBodies = (S::max_bodies > 0);
template <class S> concept HasIntegrator = requires {
  typename S::Integrator::Memory;
  S::Integrator::order;
};
template <class S> concept DeviceIsAPart = Part<typename S::Device>;
template <class S> concept JointsAreAPart = Part<typename S::Joints>;
template <class S> concept CouplingIsAPart = Part<typename S::Coupling>;
template <class S> concept FeedbackIsAPart = Part<typename S::Feedback>;
template <class S> concept ContactsAreAPart = Part<ContactsOf<S>>;

// Rejects a part in the wrong slot here instead of deep within the step.
template <class S> concept DeviceGivesCouplingInputs = !uses<typename S::Device> || requires {
  &S::Device::coupling_input;
  typename S::Device::Input;
};
template <class S> concept JointsAreTreeJoints = !uses<typename S::Joints> || requires {
  typename S::Joints::Stops;
  typename S::Joints::Prescribed;
};
template <class S>
concept CouplingIsASpring = !uses<typename S::Coupling> || requires(typename S::Coupling::Params par) {
  par.k + par.g + par.k_r + par.g_r;
};
template <class S>
concept FeedbackIsLimited = !uses<typename S::Feedback> || requires(typename S::Feedback::Params par) {
  par.gains.k + par.max_force;
  typename S::Feedback::Output;
};
template <class S> concept ContactsAreFixedOrBodyContacts = !uses<ContactsOf<S>> || requires {
  ContactsOf<S>::max_contacts;
  ContactsOf<S>::between_bodies;
};
template <class S>
concept TermsAreATermList = !uses<TermsOf<S>> || requires(typename TermsOf<S>::Params par) {
  TermsOf<S>::max_terms;
  par.of_kinds;
};
template <class S> concept NetIsAMassSpringNet = !uses<NetOf<S>> || requires {
  NetOf<S>::max_nodes;
  NetOf<S>::max_springs;
};

// Rejects likely misspellings of optional parts as members of S, but not as names of S itself or of its
// bases. Misspelt: a letter left out, doubled or exchanged with the next, another case, a related word.
#define GODOBJECT_NO_MEMBER(name) (!requires { requires !std::is_base_of_v<typename S::name, S>; })
template <class S>
concept ContactsAreNotMisspelt = GODOBJECT_NO_MEMBER(ontacts) && GODOBJECT_NO_MEMBER(Cntacts) &&
    GODOBJECT_NO_MEMBER(Cotacts) && GODOBJECT_NO_MEMBER(Conacts) && GODOBJECT_NO_MEMBER(Contcts) &&
    GODOBJECT_NO_MEMBER(Contats) && GODOBJECT_NO_MEMBER(Contacs) && GODOBJECT_NO_MEMBER(Contact) &&
    GODOBJECT_NO_MEMBER(CContacts) && GODOBJECT_NO_MEMBER(Coontacts) && GODOBJECT_NO_MEMBER(Conntacts) &&
    GODOBJECT_NO_MEMBER(Conttacts) && GODOBJECT_NO_MEMBER(Contaacts) && GODOBJECT_NO_MEMBER(Contaccts) &&
    GODOBJECT_NO_MEMBER(Contactts) && GODOBJECT_NO_MEMBER(Contactss) && GODOBJECT_NO_MEMBER(oCntacts) &&
    GODOBJECT_NO_MEMBER(Cnotacts) && GODOBJECT_NO_MEMBER(Cotnacts) && GODOBJECT_NO_MEMBER(Conatcts) &&
    GODOBJECT_NO_MEMBER(Contcats) && GODOBJECT_NO_MEMBER(Contatcs) && GODOBJECT_NO_MEMBER(Contacst) &&
    GODOBJECT_NO_MEMBER(contacts) && GODOBJECT_NO_MEMBER(CONTACTS) && GODOBJECT_NO_MEMBER(Contacts_) &&
    GODOBJECT_NO_MEMBER(contact) && GODOBJECT_NO_MEMBER(Contact_) && GODOBJECT_NO_MEMBER(Contract) &&
    GODOBJECT_NO_MEMBER(Contracts) && GODOBJECT_NO_MEMBER(Contakts) && GODOBJECT_NO_MEMBER(Collision) &&
    GODOBJECT_NO_MEMBER(Collisions) && GODOBJECT_NO_MEMBER(ContactList) &&
    GODOBJECT_NO_MEMBER(FixedContact) && GODOBJECT_NO_MEMBER(BodyContact);
template <class S>
concept TermsAreNotMisspelt = GODOBJECT_NO_MEMBER(erms) && GODOBJECT_NO_MEMBER(Trms) &&
    GODOBJECT_NO_MEMBER(Tems) && GODOBJECT_NO_MEMBER(Ters) && GODOBJECT_NO_MEMBER(Term) &&
    GODOBJECT_NO_MEMBER(TTerms) && GODOBJECT_NO_MEMBER(Teerms) && GODOBJECT_NO_MEMBER(Terrms) &&
    GODOBJECT_NO_MEMBER(Termms) && GODOBJECT_NO_MEMBER(Termss) && GODOBJECT_NO_MEMBER(eTrms) &&
    GODOBJECT_NO_MEMBER(Trems) && GODOBJECT_NO_MEMBER(Temrs) && GODOBJECT_NO_MEMBER(Tersm) &&
    GODOBJECT_NO_MEMBER(terms) && GODOBJECT_NO_MEMBER(TERMS) && GODOBJECT_NO_MEMBER(Terms_) &&
    GODOBJECT_NO_MEMBER(term) && GODOBJECT_NO_MEMBER(Spring) && GODOBJECT_NO_MEMBER(Springs);
template <class S>
concept NetIsNotMisspelt = GODOBJECT_NO_MEMBER(et) && GODOBJECT_NO_MEMBER(Nt) && GODOBJECT_NO_MEMBER(Ne) &&
    GODOBJECT_NO_MEMBER(NNet) && GODOBJECT_NO_MEMBER(Neet) && GODOBJECT_NO_MEMBER(Nett) &&
    GODOBJECT_NO_MEMBER(eNt) && GODOBJECT_NO_MEMBER(Nte) && GODOBJECT_NO_MEMBER(net) &&
    GODOBJECT_NO_MEMBER(NET) && GODOBJECT_NO_MEMBER(Net_) && GODOBJECT_NO_MEMBER(Nets) &&
    GODOBJECT_NO_MEMBER(nets) && GODOBJECT_NO_MEMBER(Mesh);
#undef GODOBJECT_NO_MEMBER
template <class S>
concept PrescribedJointsNeedDevice = std::is_empty_v<typename S::Joints::Input> || uses<typename S::Device>;
template <class S> concept TermsNeedContacts = uses<ContactsOf<S>> || !uses<TermsOf<S>>;
template <class S>
concept CoordinateTermsNeedStops = !uses<TermsOf<S>> || !TermsOf<S>::on_coordinates || requires {
  requires uses<typename S::Joints::Stops>;
};
template <class S> concept NetNeedsBodyContacts = !uses<NetOf<S>> || ContactsOf<S>::between_bodies;
template <class S> concept CouplingNeedsDevice = !uses<typename S::Coupling> || uses<typename S::Device>;
template <class S> concept FeedbackNeedsCoupling = !uses<typename S::Feedback> || uses<typename S::Coupling>;
template <class S>
concept PartsAreParts = DeviceIsAPart<S> && DeviceGivesCouplingInputs<S> && JointsAreAPart<S> &&
    JointsAreTreeJoints<S> && CouplingIsAPart<S> && CouplingIsASpring<S> && FeedbackIsAPart<S> &&
    FeedbackIsLimited<S> && ContactsAreAPart<S> && ContactsAreFixedOrBodyContacts<S> &&
    TermsAreATermList<S> && NetIsAMassSpringNet<S>;
template <class S>
concept NamesAreKnown = ContactsAreNotMisspelt<S> && TermsAreNotMisspelt<S> && NetIsNotMisspelt<S>;
template <class S>
concept Scene = HasBodies<S> && HasIntegrator<S> && NamesAreKnown<S> && PartsAreParts<S> &&
    PrescribedJointsNeedDevice<S> && TermsNeedContacts<S> && CoordinateTermsNeedStops<S> &&
    NetNeedsBodyContacts<S> && CouplingNeedsDevice<S> && FeedbackNeedsCoupling<S>;

/// Parameters of a body, constant during a run.
template <class S>
struct BodyParams {
  RigidBodyParams body;
  [[no_unique_address]] Slot<typename S::Coupling::Params, 1> coupling;
  [[no_unique_address]] Slot<typename S::Feedback::Params, 2> feedback;
  [[no_unique_address]] Slot<typename S::Device::Params, 3> device;
  [[no_unique_address]] Slot<typename S::Joints::Params, 4> joint;
};

template <class S>
struct Params {
  Real h = 1e-3;                  // time step, s, > 0
  std::size_t num_bodies = 1;     // 1..S::max_bodies
  Vec3 gravity_W = Vec3::Zero();  // m/s^2
  std::array<BodyParams<S>, S::max_bodies> bodies;
  [[no_unique_address]] Slot<typename ContactsOf<S>::Params, 10> contacts;
  [[no_unique_address]] Slot<typename TermsOf<S>::Params, 19> terms;
  [[no_unique_address]] Slot<typename NetOf<S>::Params, 21> net;
};

/// Returns the number of bodies. A scene with capacity for one body has one, so its loops vanish.
template <class S>
constexpr std::size_t num_bodies(const Params<S>& par) noexcept {
  if constexpr (S::max_bodies == 1) return 1;
  return par.num_bodies;
}
template <class S>
constexpr std::size_t num_net_nodes(const Params<S>& par) noexcept {
  if constexpr (uses<NetOf<S>>) return par.net.num_nodes;
  return 0;
}

/// True if a step has several stages, each with contacts carried over from the previous one.
template <class S>
inline constexpr bool has_stages = uses<ContactsOf<S>>&& S::Integrator::order > 1;

/// True if joints of the scene may have stops. Their coordinates are then state, and turns are counted.
template <class S>
inline constexpr bool counts_turns = requires(const typename S::Joints::State& x) {
  x.q;
};

/// True if couplings act on bodies whose joints count their turns.
template <class S>
inline constexpr bool counts_errors = counts_turns<S>&& uses<typename S::Coupling>;

/// State carried from step to step: hash, log or restore it. Forces of the last stage affect outputs alone
/// and are not hashed.
template <class S>
struct BodyState {
  RigidBodyState x;
  [[no_unique_address]] Slot<typename S::Integrator::Memory, 0> memory;
  [[no_unique_address]] Slot<typename S::Device::State, 3> device;
  [[no_unique_address]] Slot<typename S::Joints::State, 4> joint;
  [[no_unique_address]] Slot<typename S::Coupling::State, 1> coupling;
  [[no_unique_address]] Slot<typename S::Feedback::State, 2> feedback;
  [[no_unique_address]] std::conditional_t<has_stages<S>, ContactWrench, Absent<26>> contact;  // last stage
};

template <class S>
using NodeState = NodeStateOf<Slot<typename S::Integrator::NodeMemory, 0>>;

/// State of nets: nodes, and the memory of their contacts.
template <class S>
struct NetState {
  std::array<NodeState<S>, NetOf<S>::max_nodes> nodes;
  ContactMemories<NetOf<S>::max_contacts> contacts;
  [[no_unique_address]] std::conditional_t<has_stages<S>, ContactForces<NetOf<S>::max_contacts>, Absent<27>>
      forces;  // contact forces of the last stage
};

template <class S>
struct State {
  std::array<BodyState<S>, S::max_bodies> bodies;
  std::uint64_t tick = 0;  // steps taken
  [[no_unique_address]] Slot<typename TermsOf<S>::State, 19> terms;
  [[no_unique_address]] Slot<typename ContactsOf<S>::State, 10> contacts;
  [[no_unique_address]] std::conditional_t<uses<NetOf<S>>, NetState<S>, Absent<21>> net;
  [[no_unique_address]] std::conditional_t<has_stages<S>, ContactForces<ContactsOf<S>::max_contacts>,
                                           Absent<27>>
      forces;  // contact forces of the last stage
};

/// Part for every body; empty if the type is empty.
template <class S, class T, int slot>
using SlotOfAll = std::conditional_t<std::is_empty_v<T>, Absent<slot>, std::array<T, S::max_bodies>>;

/// Inputs from the devices, once per step: the sample at the END of the step.
template <class S>
struct Input {
  std::array<typename S::Device::Input, S::max_bodies> devices;
  [[no_unique_address]] SlotOfAll<S, typename S::Joints::Input, 4> joints;  // prescribed coordinates
};

/// Outputs for the devices and for observers.
template <class S>
struct BodyOutput {
  Pose X_WB;
  Twist V_WB;
  [[no_unique_address]] Slot<typename S::Feedback::Output, 2> feedback;
  [[no_unique_address]] Slot<typename S::Joints::Output, 4> joint;
  [[no_unique_address]] Slot<typename ContactsOf<S>::BodyOutput, 10> contact;
};

template <class S>
struct Output {
  std::array<BodyOutput<S>, S::max_bodies> bodies;
  [[no_unique_address]] Slot<typename ContactsOf<S>::Output, 10> contacts;
  [[no_unique_address]] Slot<typename NetOf<S>::Output, 21> net;
  [[no_unique_address]] Slot<typename TermsOf<S>::Output, 19> terms;
  Fault fault = Fault::none;
  Limited limited = Limited::none;
};

}  // namespace godobject
