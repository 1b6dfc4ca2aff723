// Scene type of every composition: any device, coupling and feedback. Parameters select joints, contacts and
// the number of bodies.
#pragma once

#include "platform/engine/of.h"

namespace godobject {

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
