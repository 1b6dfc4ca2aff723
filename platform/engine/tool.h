// Scene types of all compositions. Each has any device, coupling and feedback; parameters select joints,
// contacts and the number of bodies.
#pragma once

#include "platform/engine/engine.h"
#include "platform/engine/of.h"

namespace godobject {

inline constexpr std::size_t max_tool_terms = 64;  // of each kind

/// Returns the bytes of each part of a composition.
template <Scene S>
std::vector<PartBytes> parts_of() {
  using Joints = typename S::Joints;
  using Memory = typename S::Integrator::Memory;
  constexpr std::size_t N = S::max_bodies;
  std::vector<PartBytes> parts;
  const auto add = [&](const char* name, std::size_t params, std::size_t state, std::size_t scratch) {
    parts.push_back({name, N * params, N * state, scratch});
  };
  using W = Scratch<S>;
  constexpr std::size_t stage = sizeof(W::next) + sizeof(W::bases) + sizeof(W::velocities);
  constexpr std::size_t targets = sizeof(W::coupling_inputs) + sizeof(W::inside);
  add("bodies", sizeof(RigidBodyParams), sizeof(RigidBodyState), stage);
  if constexpr (!std::is_empty_v<Memory>) add("integrator", 0, sizeof(Memory), 0);
  add("device", sizeof(AnyDevice::Params), sizeof(AnyDevice::State), targets);
  if constexpr (uses<Joints>) {
    add("joints", sizeof(typename TreeJoints<>::Params), 0, sizeof(W::tree));
    if constexpr (prescribes<S>) {
      add("joint stops", sizeof(typename Joints::Stops::Params), 0, 0);
      add("imposed joints",
          sizeof(typename Joints::Params) - sizeof(typename TreeJoints<typename Joints::Stops>::Params),
          sizeof(typename Joints::State), sizeof(W::prescribed));
    }
  }
  add("coupling", sizeof(typename S::Coupling::Params), sizeof(typename S::Coupling::State), 0);
  add("feedback", sizeof(typename S::Feedback::Params), sizeof(typename S::Feedback::State), 0);
  std::size_t net_scratch = 0;
  if constexpr (uses<NetOf<S>>) net_scratch = sizeof(W::contacts.net);
  if constexpr (uses<ContactsOf<S>>)
    parts.push_back({"contacts", sizeof(Params<S>::contacts), sizeof(State<S>::contacts),
                     sizeof(W::contacts) - net_scratch});
  if constexpr (uses<TermsOf<S>>)
    parts.push_back({"springs, gears and loops", sizeof(Params<S>::terms), sizeof(State<S>::terms),
                     sizeof(W::contacts.terms)});
  if constexpr (uses<NetOf<S>>)
    parts.push_back({"nets", sizeof(Params<S>::net), sizeof(State<S>::net), sizeof(W::net) + net_scratch});
  return parts;
}

/// Returns the row of a scene type. name: first part of the composition's name.
template <Scene S>
CompositionRow row(const std::string& name) {
  Composition c{.name = name + "-" + std::to_string(S::max_bodies) + " " + S::Integrator::name,
                .integrator = S::Integrator::name,
                .max_bodies = S::max_bodies,
                .joints = prescribes<S>,
                .contacts = scope_of<S>(),
                .params_bytes = sizeof(Params<S>),
                .state_bytes = sizeof(State<S>),
                .scratch_bytes = sizeof(Scratch<S>),
                .parts = parts_of<S>()};
  if constexpr (uses<ContactsOf<S>>) {
    c.max_spheres = Params<S>{}.contacts.spheres.size();
    c.max_surfaces = Params<S>{}.contacts.surfaces.size();
    c.max_contacts = ContactsOf<S>::max_contacts;
  }
  if constexpr (uses<TermsOf<S>>) c.max_terms = max_tool_terms;
  if constexpr (uses<NetOf<S>>) {
    c.max_nodes = S::Net::max_nodes;
    c.max_springs = S::Net::max_springs;
    c.max_node_contacts = S::Net::max_contacts;
    c.max_attachments = S::Net::max_attachments;
    c.max_faces = S::Net::max_faces;
  }
  return {std::move(c), make_engine_of<S>};
}

/// Springs, gears, closing joints and forces of a tool.
using ToolTerms = TermList<DampedSprings<max_tool_terms>, CoordinateSprings<max_tool_terms>,
                           LoopJoints<max_tool_terms>, ConstantForces<max_tool_terms>>;

template <class I, std::size_t N, class Joints_ = None, class Contacts_ = None>
struct Tool {
  static constexpr std::size_t max_bodies = N;
  using Integrator = I;
  using Device = AnyDevice;
  using Joints = Joints_;
  using Coupling = DampedSpring;
  using Feedback = LimitedFeedback;
  using Contacts = Contacts_;
};

using AllJoints = TreeJoints<JointStops, PrescribedJoints>;

/// Contacts of a tool with the world.
using ToolContacts = FixedContacts<64, 256, 128>;
/// Contacts of many bodies with each other and the world.
using PileContacts = BodyContacts<1024, 128, 1024>;
/// Contacts of the bodies of scenes with nets; the nodes' contacts have storage of their own.
using NetContacts = BodyContacts<128, 256, 256>;

}  // namespace godobject
