// Working storage of a step, sized by the scene's parts and undefined between steps.
#pragma once

#include "core/body/angular_momentum.h"
#include "core/body/lanes.h"
#include "core/counted_errors.h"
#include "core/device/device.h"
#include "core/joint/tree.h"
#include "core/scene.h"
#include "core/solve/bodies.h"
#include "core/solve/nets.h"

namespace godobject {

/// Number type of a scene's bodies: single, or groups of four if there are more than two. A scene may
/// override it with `using Number = Real;` or Pack.
template <class S>
struct NumberOf {
  using type = std::conditional_t<(S::max_bodies > 2), Pack, Real>;
};
template <class S>
requires requires { typename S::Number; }
struct NumberOf<S> {
  using type = typename S::Number;
};
template <class S>
using Lanes = typename NumberOf<S>::type;
template <class S>
using GroupIn = Group<Lanes<S>>;
template <class S>
inline constexpr std::size_t lanes = num_lanes<Lanes<S>>;
template <class S>
inline constexpr std::size_t max_groups = (S::max_bodies + lanes<S> - 1) / lanes<S>;
template <class S>
constexpr std::size_t num_groups(const Params<S>& par) noexcept {
  return (num_bodies(par) + lanes<S> - 1) / lanes<S>;
}

/// Next state of a group, before the step is known to be valid.
template <class S>
struct Next {
  using T = Lanes<S>;
  RigidBodyStateOf<T> x;
  [[no_unique_address]] Slot<typename S::Integrator::template MemoryOf<T>, 0> memory;
  [[no_unique_address]] Slot<typename S::Coupling::template StateOf<T>, 1> coupling;
};

/// True if joints of the scene may be prescribed by the device.
template <class S>
inline constexpr bool prescribes = !std::is_empty_v<typename S::Joints::Input>;

/// Contact part of a scene, with its joints and terms.
template <class S>
struct TouchingType {
  using OfBodies = std::conditional_t<uses<typename S::Joints>, OnJoints<ContactsOf<S>>, ContactsOf<S>>;
  using OfTerms = std::conditional_t<uses<TermsOf<S>>, WithTerms<OfBodies, TermsOf<S>>, OfBodies>;
  using type = std::conditional_t<uses<NetOf<S>>, WithNet<OfTerms, NetOf<S>>, OfTerms>;
};
template <class S>
using TouchingOf = typename TouchingType<S>::type;

template <class S>
using ContactScratchOf =
    std::conditional_t<uses<ContactsOf<S>>, BodyContactScratch<TouchingOf<S>, S::max_bodies>, Absent<10>>;
/// Joint part of a scene, of bodies with or without contacts.
template <class S>
using JointScratchOf = std::conditional_t<
    !uses<typename S::Joints>, Absent<4>,
    std::conditional_t<uses<ContactsOf<S>>, TouchingJoints<S::max_bodies, typename S::Joints>,
                       Tree<S::max_bodies, typename S::Joints>>>;

/// Angular velocity expected at the end of a stage without force jumps (34), rad/s, body axes.
template <class S>
struct ExpectedTurns {
  bool known = false;
  std::array<Vector3<Lanes<S>>, max_groups<S>> w_B;
};

/// Means over a step of contact and joint forces, over the stages solved so far.
template <class S>
struct StepMeans {
  static constexpr std::size_t num_stages = S::Integrator::order + 1;  // including that before the step
  struct OfBody {
    [[no_unique_address]] Slot<typename ContactsOf<S>::BodyOutput, 10> contact;
    [[no_unique_address]] Slot<typename S::Joints::Output, 4> joint;
  };
  std::array<OfBody, S::max_bodies> bodies;
  [[no_unique_address]] std::conditional_t<
      uses<ContactsOf<S>>, ContactForces<num_stages * ContactsOf<S>::max_contacts>, Absent<28>>
      contacts;
  [[no_unique_address]] std::conditional_t<uses<NetOf<S>>, ContactForces<num_stages * NetOf<S>::max_contacts>,
                                           Absent<29>>
      of_nodes;
  [[no_unique_address]] Slot<typename TermsOf<S>::Output, 33> terms;
};

/// True if stages are iterated for joints (39).
template <class S>
inline constexpr bool iterates_joints = requires {
  requires !S::Joints::Stabilisation::uses_base;
};
template <class S>
struct Iteration {
  std::array<RigidBodyStateOf<Lanes<S>>, max_groups<S>> starts;               // bases of the stage
  std::array<StageVelocityOf<Lanes<S>>, max_groups<S>> linearised;            // velocities at which the
                                                                              // joints were linearised
  [[no_unique_address]] typename JointScratchOf<S>::Coordinates coordinates;  // coordinates at the start of
                                                                              // the stage
  StepMeans<S> means;       // means at the start of the stage
  bool subdivides = false;  // true if a stage of the step was subdivided
};

/// Turns of the attitude errors of a stage (16).
template <class S>
struct ErrorsInStage {
  std::array<Vector3<Lanes<S>>, max_groups<S>> before;  // phi of the previous solve
  std::array<TurnsAhead, S::max_bodies> turns;          // JointStops::State::ahead
  bool has_turns = false;                               // true if a body has turns, or had in this step
  bool are_large = false;  // true if errors so far in this solve may need counting
};

/// Nodes of nets at the start and the end of a stage.
template <class S>
struct NetMotions {
  std::array<NodeMotion, NetOf<S>::max_nodes> bases;
  std::array<NodeState<S>, NetOf<S>::max_nodes> next;  // committed if finite
};

/// Working storage of a step, undefined between steps.
template <class S>
struct Scratch {
  using T = Lanes<S>;
  std::array<typename CouplingInputOf<typename S::Device>::type, S::max_bodies>
      coupling_inputs;                                       // from the devices
  std::array<Next<S>, max_groups<S>> next;                   // committed if finite
  std::array<TargetOf<T>, max_groups<S>> inside;             // targets inside the step
  std::array<RigidBodyStateOf<T>, max_groups<S>> bases;      // start of the stage
  std::array<StageVelocityOf<T>, max_groups<S>> velocities;  // solution of the stage
  [[no_unique_address]] JointScratchOf<S> tree;              // the bodies with their joints
  [[no_unique_address]] std::conditional_t<uses<typename S::Joints> && uses<typename S::Feedback>,
                                           std::array<Wrench, S::max_bodies>, Absent<2>>
      wanted;  // feedback of the device's links, before limits
  [[no_unique_address]] std::conditional_t<prescribes<S>, std::array<PrescribedMotion, S::max_bodies>,
                                           Absent<6>>
      prescribed;
  [[no_unique_address]] std::conditional_t<has_stages<S>, ExpectedTurns<S>, Absent<17>> turns;
  [[no_unique_address]] std::conditional_t<counts_errors<S>, ErrorsInStage<S>, Absent<34>> errors;
  [[no_unique_address]] std::conditional_t<uses<ContactsOf<S>>, std::array<StageImpulseOf<T>, max_groups<S>>,
                                           Absent<35>>
      impulses;  // of the last solve
  [[no_unique_address]] std::conditional_t<iterates_joints<S>, Iteration<S>, Absent<20>> iteration;
  [[no_unique_address]] std::conditional_t<uses<NetOf<S>>, NetMotions<S>, Absent<21>> net;
  [[no_unique_address]] ContactScratchOf<S> contacts;
  [[no_unique_address]] Slot<typename TermsOf<S>::State, 32> term_forces;  // of the last solve
  [[no_unique_address]] std::conditional_t<uses<ContactsOf<S>> || uses<typename S::Joints>, StepMeans<S>,
                                           Absent<30>>
      means;
};

}  // namespace godobject
