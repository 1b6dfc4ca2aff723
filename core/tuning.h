// Every number of the solver that physics does not give: what it means, its unit, and what chose it.
//
// A scene's own numbers (stiffness, push_out, limits, capacities) are its parameters and not here, nor are those of
// mathematics: pi, coefficients of schemes and polynomials. To change one of these, change it here and run the tests named beside
// it, which draw their cases at random. Where no sweep chose a number, its comment says what it follows from.
// tests/docs/check_tuning.py refuses others elsewhere in core.
#pragma once

#include <algorithm>

#include "core/math/types.h"

namespace godobject {

// How a body turns in a stage (core/body, core/math/rotation_error.h), and the second-order scheme
// (core/integrator_tr_bdf2.h).

/// rad, of h |w| sqrt(I_max / I_min): beyond it a stage takes less of Newton's gyroscopic term. No choice but the end of the proof,
/// docs/theory/stage.md: with more, that term could do work. What TR-BDF2 does not damp, or does not know the acceleration of,
/// is of second order up to it. tests/core/test_stability.cc.
inline constexpr Real max_swing = 0.5;
/// rad, of h^2 |w'|: a step that begins with a change of more in its turn is taken as implicit Euler stages. As max_swing, without a
/// sweep of its own.
inline constexpr Real max_swing_change = 0.5;
/// (16), |cos(alpha / 2)|: nearer than that to the half turn an attitude error keeps its side. 0.1 rad: more than a tracked hand
/// trembles, and a side that is kept holds 6 % more energy than the shorter one at most (docs/theory/stage.md). No sweep.
inline constexpr Real half_turn_band = 0.05;

/// rad: a step in which a body, or its angular velocity, turns farther is taken as implicit Euler stages: an extrapolation
/// along a straight line means nothing. tests/core/test_stability.cc; docs/decisions/045.
inline constexpr Real max_extrapolated_turn = 0.25;

/// rad: the same of a body in a scene with nets, whose nodes are extrapolated with it. tests/core/net/test_stability.cc.
inline constexpr Real max_carrier_turn = 0.1;

// Joints where a stage is predicted to end (core/joint).

/// rad: a stage that turns a body farther has its joints and contacts where it starts. tests/core/joint, spins to
/// 10 000 rad/s.
inline constexpr Real max_predicted_turn = 0.5;
/// (39), of the distance from the joint: what turns may leave a joint violated by before a stage is iterated. This and the next
/// four: tests/core/joint/test_heavy_ends.cc; docs/decisions/035.
inline constexpr Real max_bend = 1e-5;
/// How often a stage is iterated, and in how many parts it is taken where that does not do: more by this factor each time.
inline constexpr int max_joint_iterations = 8, part_ratio = 4, max_parts = 16;
/// The same of scenes with nets, whose iteration stops early. tests/core/net/test_attached_sweep.cc; docs/decisions/055.
inline constexpr int max_parts_with_nets = 64;
/// rad: the farthest turn in an iteration.
inline constexpr Real max_iterated_turn = 3;
/// After more of these iterations TR-BDF2 forgets its acceleration.
inline constexpr int max_calm_iterations = 1;
/// rad, and of the lever: a joint that is farther apart where a step starts lets its stages be solved once.
inline constexpr Real max_apart = 1e-4;
/// rad: the turn that a joint takes back in one stage. tests/core/joint, joints pulled apart.
inline constexpr Real max_turned_back = 0.15;
/// Share of the distance from the centre of mass to the anchor by which a joint moves back in one stage at most. The same
/// tests.
inline constexpr Real max_moved_back = 0.2;
/// Share of a coordinate's pivot: a stop stiffer than that turns it round within the stage, and TR-BDF2 forgets its
/// acceleration. tests/core/joint, stops.
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
/// tests/core/contact/test_sample_gaps.cc, bodies/test_ridges.cc.
inline constexpr Real same_contact = 0.5;
/// Share of the thinnest half extent: edges nearer than that may come to bear a force. This and the next five:
/// tests/core/contact/bodies/test_edges.cc, bodies/test_overlap.cc.
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

/// What moves farther in a stage than it is large is swept, in so many steps of its way at most. tests/core/contact/test_tunnelling.cc,
/// with the next two.
inline constexpr int max_advances = 32;
/// What is in touch there: of the radius of a sphere, and of the reach of edges.
inline constexpr Real sweep_tolerance = 0.01, edge_touch = 0.2;
/// Share of the thinnest half extent: boxes that are deeper in each other are sunk, and part along one axis.
/// bodies/test_overlap.cc, sunk pairs.
inline constexpr Real sunk_depth = 0.5;

// Rest penetration (35).

/// Multiple of the largest stored penetration by which a body's is relaxed in a stage at most. Bodies that are locked
/// into each other do not move with it, and solves that stop early may not give all of it back. test_few_blocks.cc,
/// bodies/test_stability.cc: without a bound, cases gain energy.
inline constexpr Real max_relaxation = 30;
/// Stages: between bodies the rest penetration falls below their depth by no more than it is relaxed in so many; nothing
/// winds up. Against the world it falls on. bodies/test_overlap.cc.
inline constexpr Real max_pushed_steps = 3;

// Room: what is fixed for all scenes.

/// Blocks beside the diagonal for each body or node of a scene's capacity, where it says no number: those of the bricks of S4 in a
/// heap; what has no room is iterated (28). docs/decisions/022; with a tenth of it: test_few_blocks.cc.
inline constexpr std::size_t blocks_per_body = 8;
/// Pairs of bodies, for each body, of which the nodes that one carries touch the other: without a place a pair is left to the
/// iteration. A net is held by two jaws and lies on one or two bodies more; no sweep.
inline constexpr std::size_t net_pairs_per_body = 4;

/// Materials of a scene, with a law for each two: tissues, an instrument's parts and the table. 64 laws are 3 kB.
inline constexpr std::size_t max_materials = 8;

// Newton's method over the modes of contacts (29).

/// With fewer some piles gain energy. Bodies on joints need twice as many: what joints take back (18) presses stiff
/// contacts together. bodies/test_stability.cc, bodies/test_joint_stability.cc; docs/decisions/022 and 023.
inline constexpr int max_newton_iterations = 16, max_newton_iterations_on_joints = 32;
/// Share of an island's largest normal force: a step whose contact forces miss their laws by more says so. No sweep: ten times what
/// an iteration that converges may leave. tests/core/contact/bodies/test_solver_limits.cc.
inline constexpr Real doubtful_residual = 0.1;
/// Share of the slope at the beginning that a line search (29) may leave; the same of the search for the multiple of V.
/// bodies/test_stability.cc.
inline constexpr Real line_tolerance = 0.1, scale_tolerance = 1e-3;
/// Steps of either search: each halves the interval at worst.
inline constexpr int max_line_steps = 16;
/// Share of what may be left that a step of either search aims at: so rounding does not leave it above. No sweep: the middle.
inline constexpr Real line_aim = 0.5;
/// The multiple of V up to which the least E is sought: with the modes as they were solved for it is at 1, and a search that ends here is
/// taken up by the next iteration. No sweep.
inline constexpr Real max_scale = 2;

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
/// The same among bodies, without tangents.
struct FrictionAmongBodies {
  static constexpr bool tangents = false;
  static constexpr int by_tangent = 0, by_secant = 5;
  // friction that would change by less stays as it is in the next iteration: there is less to factor again
  static constexpr Real friction_left_alone = 1e-5;
  // What lasts is found in two iterations, and then to its end: what slips without being pushed is accelerated by what
  // friction lacks of its cone (bodies/test_laws.cc). Where many bodies hit each other the next ones find more of it and
  // are content with less: of friction in the end with what there is, of normal forces with as much as
  // bodies/test_stability.cc allows.
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
inline constexpr int max_cg_iterations_seeking = 3, max_cg_iterations = 8;
/// In how many strips the nodes of a carrier are taken into groups of four: two groups that do not wait for each other. Of 2, 4, 6,
/// 8, 16 and 32 the one with the shortest steps of S6, by up to 7 %; iterations differ by 3 %. docs/decisions/059.
inline constexpr std::uint32_t node_strips = 8;
/// How many nodes are looked at to fill a group: more than a node has neighbours. No sweep.
inline constexpr std::size_t nodes_looked_ahead = 64;

/// A Newton iteration of a system with nets may take one in so many of the iterations that are left: contacts may leave their modes,
/// and the next one is to have some. tests/core/net/test_stability.cc.
inline constexpr int iteration_parts = 2;
/// (45)  With less than this share of V^T A V in its deformation a net moves with its carrier but for rounding.
inline constexpr Real least_deforming = 1e-12;

// Gaps in a device's samples (core/device). tests/core/contact/test_sample_gaps.cc; docs/decisions/026.

/// Steps without a valid sample that are bridged: the target goes on as it moved. What a late answer or a spike costs.
inline constexpr int bridged_steps = 3;
/// s after a longer gap in which the feedback does not grow, at least (the ramp, if that takes longer), and in which it
/// then grows: what the softest of the swept couplings takes to catch up.
inline constexpr Real quiet_after_gap = 0.25, growth_after_gap = 0.25;
/// s: a gap of up to so many leaves what the device held where it had it in the hand, which has gone no farther than the ramp makes
/// good.
inline constexpr Real grip_lasts = 0.1;
/// After a gap that was bridged the feedback may not grow for this many times the gap: meanwhile what the bridge was off
/// by dies down in the coupling, to 3 % of it.
inline constexpr Real calm_per_gap = 30;

// The balance of energy (38). tests/platform/session/test_energy_gained.cc, test_attack_scenes.cc,
// tests/core/contact/test_energy_of_contacts.cc; docs/decisions/039, 053.

/// Share of the energy at work that a scene may gain within the window, in which numbers are of second order only.
inline constexpr Real gain_allowed = 0.01;
/// J, which no hand feels; and the share of E that it is rounded by: less is no gain.
inline constexpr Real gain_floor = 1e-12, gain_rounding = 1e-12;
/// (58), multiple of the energy at hand: a step that ends with more kinetic energy is a failed solve. Far
/// above the gains of any order's error, far below those of a division by nothing.
/// tests/core/test_energy_rise.cc.
inline constexpr Real max_rise = 100;
/// Share of what the springs of nets hold: less is no gain. Their iteration ends at a tolerance, and so do their contacts'
/// forces: a net that is held pressed moves by it, back and forth. tests/core/net/test_stability.cc.
inline constexpr Real net_gain_floor = 1e-3;
/// Steps: what a scene has lost or gained for fewer is no loss and no gain. A step that a blow, or a snap of joints, is too fast
/// for errs by its order, to either side, and the next ones take it back.
inline constexpr std::size_t gain_steps = 8;
/// s, at most: gains that are older are forgotten. At least half of it is remembered.
inline constexpr Real gain_window = 1;

// What differs from what it should be by rounding alone: checks of parameters and inputs, and geometry. These are far above the
// rounding of a double and far below what a hand or a solver feels; no sweep has chosen one.

/// The square of a quaternion's length may be so far from 1, in a scene and in a sample: its length by half of it.
inline constexpr Real quaternion_tolerance = 1e-6, sample_quaternion_tolerance = 2e-6;
/// A joint's frame may be so far from a rotation, and of an inertia this share not symmetric.
inline constexpr Real rotation_tolerance = 1e-9, symmetry_tolerance = 1e-9;
/// The share of I_max / I_min that the square of a body's anisotropy is at least.
inline constexpr Real anisotropy_share = 0.999;
/// Two axes are opposite where 1 + z . u is less.
inline constexpr Real opposite_axes = 1e-12;
/// m: shorter vectors have no direction, since their squares leave the range of normal numbers.
inline constexpr Real min_length = 1e-150;
/// A share of a triangle's size: nearer than that to it, the direction from its nearest point is rounding error.
inline constexpr Real touching_triangle = 1e-12;
/// Triangles of less height than this share of their longest edge are none; sums of unit normals that are shorter cancel each other.
inline constexpr Real degenerate_height = 1e-9, cancelled_normals = 1e-9;
/// The square of the radius of the sphere round a cell, in edges of the cell: (sqrt(3) / 2)^2, and what is rounded.
inline constexpr Real cell_radius_sq = 0.75001;

}  // namespace godobject
