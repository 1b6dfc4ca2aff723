// Scene types of tools: which device moves them, how their links are joined, what they touch.
#pragma once

#include "platform/engine/of.h"

namespace godobject {

template <class I, std::size_t N, class Device_, class Coupling_, class Feedback_, class Joints_,
          class Contacts_>
struct Tool {
  static constexpr std::size_t max_bodies = N;
  using Integrator = I;
  using Device = Device_;
  using Joints = Joints_;
  using Coupling = Coupling_;
  using Feedback = Feedback_;
  using Contacts = Contacts_;
};

template <class I, std::size_t N, class Joints, class Contacts>
using FreeTool = Tool<I, N, None, None, None, Joints, Contacts>;
/// Follows poses, shows nothing.
template <class I, std::size_t N, class Joints, class Contacts>
using PoseTool = Tool<I, N, PoseDevice, DampedSpring, None, Joints, Contacts>;
template <class I, std::size_t N, class Joints, class Contacts>
using HapticTool = Tool<I, N, PoseDevice, DampedSpring, LimitedFeedback, Joints, Contacts>;

using BareJoints = TreeJoints<>;
using JointsWithStops = TreeJoints<JointStops>;
using JointsWithAll = TreeJoints<JointStops, ImposedJoints>;

/// Of a tool with the world.
using ToolContacts = FixedContacts<64, 256, 128>;
/// Of many bodies with each other and the world.
using PileContacts = BodyContacts<1024, 128, 1024>;

/// Adds the tool with both integrators.
template <template <class, std::size_t, class, class> class ToolOf, std::size_t N, class Joints,
          class Contacts = None>
void add_tool(std::vector<CompositionRow>& table, const char* name, DeviceKind kind) {
  table.push_back(row<ToolOf<ImplicitEuler, N, Joints, Contacts>>(name, kind));
  table.push_back(row<ToolOf<TrBdf2, N, Joints, Contacts>>(name, kind));
}

}  // namespace godobject
