// Scene types measured by the study. Each adds one component to the previous type, so that its cost is a
// difference ("device" has no coupling). Articulated types also exist with each component of the joints
// alone, and with each stabilisation.
#pragma once

#include "core/godobject.h"
#include "core/solve/bodies.h"

namespace godobject::study {

/// Free bodies.
template <class I, std::size_t N>
struct Free {
  static constexpr std::size_t max_bodies = N;
  using Integrator = I;
  using Device = None;
  using Coupling = None;
  using Joints = None;
  using Feedback = None;
};

/// A device without coupling.
template <class I, std::size_t N>
struct DeviceOnly : Free<I, N> {
  using Device = PoseDevice;
};

/// A tool that follows a pose.
template <class I, std::size_t N>
struct Follower : DeviceOnly<I, N> {
  using Coupling = DampedSpring;
};

/// A tool that follows a pose and displays a force.
template <class I, std::size_t N>
struct Haptic : Follower<I, N> {
  using Feedback = LimitedFeedback;
};

/// A tool moved by increments through a clutch.
template <class I, std::size_t N>
struct Relative : Follower<I, N> {
  using Device = RelativeDevice;
};

/// A tool moved by a force.
template <class I, std::size_t N>
struct Admittance : DeviceOnly<I, N> {
  using Device = AdmittanceDevice;
};

/// Bodies on joints without coupling.
template <class I, std::size_t N>
struct FreeJoints : Free<I, N> {
  using Joints = TreeJoints<>;
};

/// A tool of coupled bodies on joints.
template <class I, std::size_t N, class J>
struct FollowerOnJoints : Follower<I, N> {
  using Joints = J;
};
template <class I, std::size_t N>
struct Tool : FollowerOnJoints<I, N, TreeJoints<>> {};
template <class I, std::size_t N>
struct ToolWithStops : FollowerOnJoints<I, N, TreeJoints<JointStops>> {};
template <class I, std::size_t N>
struct ToolWithImposed : FollowerOnJoints<I, N, TreeJoints<None, PrescribedJoints>> {};
template <class I, std::size_t N>
struct ToolWithAll : FollowerOnJoints<I, N, TreeJoints<JointStops, PrescribedJoints>> {};

/// A tool with another joint stabilisation. Types that use the base are of first order.
template <class I, std::size_t N, class Stabilisation>
struct ToolHeldBy : FollowerOnJoints<I, N, TreeJoints<None, None, Stabilisation>> {};

/// A tool of ten spheres over a plane, S2.
template <class I, std::size_t N>
struct PressedTool : Follower<I, N> {
  using Contacts = FixedContacts<10 * N, 1, 10 * N>;
};

/// A ball over a plane.
template <class I, std::size_t N>
struct Ball : Free<I, N> {
  using Contacts = FixedContacts<N, 1, N>;
};

/// Bricks of a box and eight spheres on a plane, S4.
template <class I, std::size_t N>
struct Bricks : Follower<I, N> {
  using Contacts = BodyContacts<8 * N, N + 1, 36 * N>;
};

/// A tool with feedback and a net of `nodes` nodes, among obstacles of the world or shapes of its own, S6.
template <class I, std::size_t nodes>
struct NetTool : Haptic<I, 1> {
  using Contacts = BodyContacts<1, 1, 4>;
  using Net = MassSpringNet<nodes, 3 * nodes, nodes / 2>;
};

/// Returns the capacity in a composition's name: bodies, or nodes of nets.
template <class S>
constexpr std::size_t capacity_of() {
  if constexpr (uses<NetOf<S>>) return S::Net::max_nodes;
  return S::max_bodies;
}

}  // namespace godobject::study
