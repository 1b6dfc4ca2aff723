// Every number of the solver that physics does not give: what it means, its unit, and what chose it.
//
// A scene's own numbers (stiffness, push_out, limits, capacities) are its parameters and not here. To change one of
// these, change it here and run the tests named beside it; all of them draw their cases at random.
#pragma once

#include <algorithm>

#include "core/math/types.h"

namespace godobject {

// The second-order scheme (core/integrator_tr_bdf2.h).

/// rad: a step in which a body, or its angular velocity, turns farther is taken as implicit Euler stages: an extrapolation
/// along a straight line means nothing. tests/core/test_stability.cc; docs/decisions/045.
inline constexpr Real max_extrapolated_turn = 0.25;

/// rad: the same of a body in a scene with nets, whose nodes are extrapolated with it. tests/core/net/test_stability.cc.
inline constexpr Real max_carrier_turn = 0.1;

// Joints where a stage is predicted to end (core/joint).

/// rad: a stage that turns a body farther has its joints and contacts where it starts. tests/articulated, spins to
/// 10 000 rad/s.
inline constexpr Real max_predicted_turn = 0.5;
/// (39), of the distance from the joint: what turns may leave a joint violated by before a stage is iterated, how often it
/// is, and in how many parts it is taken where that does not do: more by this factor each time. The farthest turn, rad, in
/// an iteration. tests/core/joint/test_heavy_ends.cc.
inline constexpr Real max_bend = 1e-5;
inline constexpr int max_joint_iterations = 8, part_ratio = 4, max_parts = 16;
inline constexpr Real max_iterated_turn = 3;
/// After more of these iterations TR-BDF2 forgets its acceleration. The same tests, heavy ends.
inline constexpr int max_calm_iterations = 1;
/// rad, and of the lever: a joint that is farther apart where a step starts lets its stages be solved once.
inline constexpr Real max_apart = 1e-4;
/// rad: the turn that a joint takes back in one stage. tests/articulated, joints pulled apart.
inline constexpr Real max_turned_back = 0.15;
/// Share of the distance from the centre of mass to the anchor by which a joint moves back in one stage at most. The same
/// tests.
inline constexpr Real max_moved_back = 0.2;
/// Share of a coordinate's pivot: a stop stiffer than that turns it round within the stage, and TR-BDF2 forgets its
/// acceleration. tests/articulated, stops.
inline constexpr Real stiff_stop_share = 0.2;
/// (21), (40), of a body's A in a stage: below the first geometric stiffness is not felt; where more than the second is
/// left out of it, TR-BDF2 forgets its acceleration. tests/core/joint/test_contradicted_targets.cc,
/// test_heavy_ends.cc.
inline constexpr Real felt_share = 0.01, stiff_joint_share = 0.1;

// What may touch (core/contact/find).

/// Share of a sphere's radius: nearer than that it may come to bear a force in the stage.
/// tests/core/contact/test_pressed_rest.cc.
inline constexpr Real contact_reach = 0.25;
/// The cosine between normals below which the contact is another one: the normal has turned round a corner.
/// tests/core/contact/test_sample_gaps.cc, test_touching_ridges.cc.
inline constexpr Real same_contact = 0.5;
/// Share of the thinnest half extent: edges nearer than that may come to bear a force. This and the next five:
/// tests/core/contact/bodies/test_edges.cc, test_touching_overlap.cc.
inline constexpr Real edge_reach = 0.02;
/// Share of the half length of an edge: edges that cross nearer to an end are left to the sphere there.
inline constexpr Real edge_end = 0.01;
/// Shares of the faces' depth and of the reach by which edges may be deeper than the faces. Where boxes lie on each other
/// both axes are nearly one.
inline constexpr Real deeper_than_faces = 0.1, deeper_than_reach = 0.1;
/// The cosine between normals from which on they are one: boxes that lie on each other touch at all corners of the area
/// that they have in common, however they are tilted.
inline constexpr Real same_normal = 0.995;
/// The sine between edges below which they are parallel.
inline constexpr Real min_edge_sine = 0.01;

/// What moves farther in a stage than it is large is swept: steps of its way, and what is in touch, of the radius or of the
/// reach of edges. tests/core/contact/test_tunnelling.cc.
inline constexpr int max_advances = 32;
inline constexpr Real sweep_tolerance = 0.01, edge_touch = 0.2;
/// Share of the thinnest half extent: boxes that are deeper in each other are sunk, and part along one axis.
/// test_touching_overlap.cc, sunk pairs.
inline constexpr Real sunk_depth = 0.5;

// Rest penetration (35).

/// Multiple of the largest stored penetration by which a body's is relaxed in a stage at most. Bodies that are locked
/// into each other do not move with it, and solves that stop early may not give all of it back. test_few_blocks.cc,
/// test_touching_stability.cc: without a bound, cases gain energy.
inline constexpr Real max_relaxation = 30;
/// Stages: between bodies the rest penetration falls below their depth by no more than it is relaxed in so many; nothing
/// winds up. Against the world it falls on. test_touching_overlap.cc.
inline constexpr Real max_pushed_steps = 3;

// Newton's method over the modes of contacts (29).

/// With fewer some piles gain energy. Bodies on joints need twice as many: what joints take back (18) presses stiff
/// contacts together. test_touching_stability.cc, test_touching_joint_stability.cc; docs/decisions/022 and 023.
inline constexpr int max_newton_iterations = 16, max_newton_iterations_on_joints = 32;
/// Share of the slope at the beginning that a line search (29) may leave; the same of the search for the multiple of V.
/// test_touching_stability.cc.
inline constexpr Real line_tolerance = 0.1, scale_tolerance = 1e-3;
/// Steps of either search: each halves the interval at worst.
inline constexpr int max_line_steps = 16;

/// How far friction is sought: iterations by tangents (25), then by secants (24); the rest leave it as it is, which cannot
/// drive. The tolerances are parts of the largest normal force.
struct FrictionAgainstTheWorld {
  static constexpr bool tangents = true;
  static constexpr int by_tangent = 4, by_secant = 2;
  static constexpr Real friction_left_alone = 0;
  // to its end: position errors of the reference `press` grow above this (tests/core/contact/test_reference.cc)
  static constexpr Real friction_tolerance(int) noexcept { return 1e-6; }
  static constexpr Real normal_tolerance(int) noexcept { return 1e-6; }
};
struct FrictionAmongBodies {
  static constexpr bool tangents = false;
  static constexpr int by_tangent = 0, by_secant = 5;
  // friction that would change by less stays as it is in the next iteration: there is less to factor again
  static constexpr Real friction_left_alone = 1e-5;
  // What lasts is found in two iterations, and then to its end: what slips without being pushed is accelerated by what
  // friction lacks of its cone (test_touching_laws.cc). Where many bodies hit each other the next ones find more of it and
  // are content with less: of friction in the end with what there is, of normal forces with as much as
  // test_touching_stability.cc allows.
  static constexpr Real friction_tolerance(int iteration) noexcept {
    return iteration > 3 ? 3e-3 * static_cast<Real>(1 << (iteration - 1)) : 1e-5;
  }
  static constexpr Real normal_tolerance(int iteration) noexcept {
    return std::min(3e-3 * static_cast<Real>(1 << (iteration > 1 ? iteration - 1 : 0)), Real(12e-3));
  }
};

/// Nodes of nets are many and light: what friction lacks of its cone moves none of them far. tests/core/net/test_stability.cc.
struct FrictionOnNets {
  static constexpr bool tangents = FrictionAmongBodies::tangents;
  static constexpr int by_tangent = FrictionAmongBodies::by_tangent,
                       by_secant = FrictionAmongBodies::by_secant;
  static constexpr Real friction_left_alone = 1e-3;
  static constexpr Real friction_tolerance(int iteration) noexcept { return normal_tolerance(iteration); }
  static constexpr Real normal_tolerance(int iteration) noexcept {
    return FrictionAmongBodies::normal_tolerance(iteration);
  }
};

// Springs of nets. tests/core/net/test_stability.cc.

/// (46), of the energy that springs exchange in a stage, what they may gain: nets that are pressed gain up to 0.03 of it, those
/// that go on gaining 0.17 and more.
inline constexpr Real max_spring_gain = 0.05;

/// (48), of the angular momentum that motions of this speed may have: a step that changes more of it does not resolve how its
/// springs turn, and giving it back may gain energy. The same tests.
inline constexpr Real max_given_back = 0.05;

// Conjugate gradients (28), where blocks have no room. test_few_blocks.cc.

/// m/s: the iterations end when all velocities are known to this.
inline constexpr Real velocity_tolerance = 1e-3;
/// Iterations of conjugate gradients in a Newton iteration: few while friction is still sought.
inline constexpr int max_iterations_seeking = 3, max_iterations = 8;

}  // namespace godobject
