// All numbers of the solver that physics does not determine, with their meaning, unit and origin.
//
// Parameters of a scene (stiffness, push_out, limits, capacities) are not here. Mathematical constants (pi,
// coefficients of schemes and polynomials) are not here either. After a change, run the tests named beside
// the number; they draw random cases. Without such a sweep, the comment gives the reason.
// tests/docs/check_tuning.py rejects such numbers elsewhere in core.
#pragma once

#include <algorithm>

#include "core/math/types.h"

namespace godobject {

// Rotation of a body in a stage (core/body, core/math/rotation_error.h) and the second-order scheme
// (core/integrator_tr_bdf2.h).

/// Limit of h |w| sqrt(I_max / I_min), rad. Above it, a stage scales Newton's gyroscopic term down, because
/// the full term could do work (proof: docs/theory/stage.md). Undamped motion and unknown accelerations are
/// of second order up to it. tests/core/test_stability.cc.
/// Steps whose initial change of rotation h^2 |w'| is above it are taken as implicit Euler stages.
inline constexpr Real max_swing = 0.5;
/// Half-turn band, of |cos(alpha / 2)|: nearer to the half turn, an attitude error keeps its side (16). 0.1
/// rad exceeds the tremor of a tracked hand. A kept side holds at most 6 % more energy than the shorter one
/// (docs/theory/stage.md). No sweep.
inline constexpr Real half_turn_band = 0.05;

/// Share of a rotation that must be about the axes of a joint, as cos^2 of half the rest: 120 degrees.
/// Beyond, an error has no twist about them whose turns could be counted (16). A flip to the other side then
/// counts if its axis is within 60 degrees of the joint's. tests/core/joint/test_wound_targets.cc.
inline constexpr Real min_twist_share = 0.25;

/// Rotation of a body in a step, and of its angular velocity, rad, above which implicit Euler stages are
/// taken, because linear extrapolation fails. tests/core/test_stability.cc; docs/decisions/045.
inline constexpr Real max_extrapolated_turn = 0.25;

/// As max_extrapolated_turn, rad, in scenes with nets, whose nodes are extrapolated with the body.
/// tests/core/net/test_stability.cc.
inline constexpr Real max_carrier_turn = 0.1;

// Joints at the predicted end of a stage (core/joint).

/// Limit of a body's rotation in a stage, rad. Above it, joints and contacts are evaluated at the start of
/// the stage instead of its predicted end. tests/core/joint, spins to 10 000 rad/s.
inline constexpr Real max_predicted_turn = 0.5;
/// Joint violation per lever length above which a stage is iterated (39). This and the next four:
/// tests/core/joint/test_heavy_ends.cc; docs/decisions/035.
inline constexpr Real min_iterated_violation = 1e-5;
/// Limit of iterations of a stage, factor between attempts with substeps, and limit of substeps.
inline constexpr int max_joint_iterations = 8, substep_ratio = 4, max_substeps = 16;
/// Limit of substeps in scenes with nets, whose iterations are cut off earlier.
/// tests/core/net/test_attached_sweep.cc; docs/decisions/055.
inline constexpr int max_substeps_with_nets = 64;
/// Largest rotation in an iteration, rad.
inline constexpr Real max_iterated_turn = 3;
/// Joint violation at the start of a step above which its stages are solved once, without iterations. In rad
/// for rotations, as a share of the lever for translations.
inline constexpr Real max_apart = 1e-4;
/// Largest rotation by which a joint is corrected in one stage, rad. tests/core/joint, joints pulled apart.
inline constexpr Real max_turned_back = 0.15;
/// Largest correction of a joint in one stage, as a share of the distance from the centre of mass to the
/// anchor. The same tests.
inline constexpr Real max_moved_back = 0.2;
/// Share of a coordinate's pivot. A stiffer stop reverses the coordinate within the stage, and TR-BDF2
/// discards its acceleration. tests/core/joint, stops.
inline constexpr Real stiff_stop_share = 0.2;
/// K_rigid of gears (61) and closing joints (62), as a multiple of their bodies' effective mass. Each solve
/// leaves 1 / K_rigid of a change of the multiplier; larger ratios cost digits of the factor.
/// tests/core/term/test_gears.cc, test_loops.cc.
inline constexpr Real rigid_mass_ratio = 1e6;
/// Shares of a body's A in a stage, for the geometric stiffness (21), (40). It is ignored below the first. If
/// more than the second is left out of A, TR-BDF2 discards its acceleration.
/// tests/core/joint/test_contradicted_targets.cc, test_heavy_ends.cc.
inline constexpr Real min_stiffness_share = 0.01, stiff_joint_share = 0.1;

// Search for contacts (core/contact/find).

/// Share of a sphere's radius: distance below which its contact may become active in the stage.
/// tests/core/contact/test_pressed_rest.cc.
inline constexpr Real contact_reach = 0.25;
/// Cosine between normals below which a contact counts as a new one, because its normal has turned round a
/// corner. tests/core/contact/test_sample_gaps.cc, bodies/test_ridges.cc.
inline constexpr Real same_contact = 0.5;
/// Share of the thinnest half extent: distance below which contacts of edges may become active. This and the
/// next five: tests/core/contact/bodies/test_edges.cc, bodies/test_overlap.cc.
inline constexpr Real edge_reach = 0.02;
/// Share of an edge's half length: crossings nearer to an end are left to the sphere there.
inline constexpr Real edge_end = 0.01;
/// Share of the sum of the faces' depth and the reach by which edges may be deeper than faces. For boxes
/// lying on each other both axes are nearly one.
inline constexpr Real deeper_edges = 0.1;
/// Cosine between normals above which they count as equal. Boxes lying on each other then touch at all
/// corners of their common area, however they are tilted.
inline constexpr Real same_normal = 0.995;
/// Sine of the angle between edges below which they count as parallel.
inline constexpr Real min_edge_sine = 0.01;
/// Share of the half thickness of the thinner shape: radius of the ball in the corner of a box. It selects
/// the face that the corner meets. bodies/test_shapes_meet.cc.
inline constexpr Real corner_ball = 0.1;
/// Relative tolerance of the radius of a sphere that rounds a corner or an end, and of a body's anisotropy
/// squared, I_max / I_min. Numbers in a file are rounded.
inline constexpr Real rounding_tolerance = 1e-3;

/// Smallest angle between the normals of two contacts of a sphere with a mesh or height field, rad. One
/// degree: edges of nearly flat surfaces are not felt. tests/core/contact/test_valleys.cc.
inline constexpr Real least_face_turn = 0.0175;

/// Limit of steps along the path of a swept shape, one that moves farther in a stage than its size. This and
/// the next two: tests/core/contact/test_tunnelling.cc.
inline constexpr int max_advances = 32;
/// Distances that count as touching in a sweep: share of a sphere's radius, share of the reach of edges.
inline constexpr Real sweep_tolerance = 0.01, edge_touch = 0.2;
/// Share of the thinnest half extent: deeper boxes count as sunk and separate along one axis.
/// bodies/test_overlap.cc, sunk pairs.
inline constexpr Real sunk_depth = 0.5;

// Rest penetration (35).

/// Limit of a body's relaxation in a stage, as a multiple of its largest stored penetration. Bodies locked
/// into each other cannot move with it, and solves that stop early may not return it. Without a bound, cases
/// gain energy. test_few_blocks.cc, bodies/test_stability.cc.
inline constexpr Real max_relaxation = 30;
/// Maximum lag of the rest penetration below the depth between bodies, in stages of relaxation, so that it
/// does not accumulate. Against the world there is no such bound. bodies/test_overlap.cc.
inline constexpr Real max_pushed_steps = 3;

// Capacities, fixed for all scenes.

/// Blocks beside the diagonal per body or node, unless the scene sets a number. Enough for the heap of bricks
/// of scene S4. Further blocks are left to iteration (28). docs/decisions/022; with a tenth of it:
/// test_few_blocks.cc.
inline constexpr std::size_t blocks_per_body = 8;
/// Pairs of a carrier's nodes with another body, per body; further pairs are left to the iteration. A net is
/// held by two jaws and lies on one or two bodies more. No sweep.
inline constexpr std::size_t net_pairs_per_body = 4;

/// Faces of a mesh or height field that a sphere touches at a time; further ones are reported as contacts
/// without room. A pit of four faces needs four; a sphere on spikes smaller than itself more than eight. Four
/// bits of a contact's key. tests/core/contact/test_nearest_points.cc.
inline constexpr std::size_t max_touched_faces = 16;

/// Materials of a scene, with a law per pair: tissues, parts of an instrument, the table. 64 laws take 3 kB.
inline constexpr std::size_t max_materials = 8;

/// Rotations of joints about which an error may have whole turns at a time (16). Flips about further ones are
/// not counted. A wound tool needs one, or both of a universal joint. No sweep.
inline constexpr std::size_t max_wound_axes = 4;

// Newton's method over the modes of contacts (29).

/// Limit of iterations. With fewer, some piles gain energy. Bodies on joints have twice as many, because
/// joint corrections (18) press stiff contacts together. bodies/test_stability.cc,
/// bodies/test_joint_stability.cc; docs/decisions/022 and 023.
inline constexpr int max_newton_iterations = 16;
/// Share of an island's largest normal force: residuals above it are reported as Limited::contact_residual.
/// Ten times the residual of a converged iteration, without a sweep.
/// tests/core/contact/bodies/test_solver_limits.cc.
inline constexpr Real doubtful_residual = 0.1;
/// Tolerances of the line search (29) and of the search for the multiple of V, as shares of the initial
/// slope. bodies/test_stability.cc.
inline constexpr Real line_tolerance = 0.1, scale_tolerance = 1e-3;
/// Limit of steps of either search. Each halves the interval at worst.
inline constexpr int max_line_steps = 16;
/// Upper end of the search for the multiple of V with the least E. The minimum is at 1 for unchanged modes;
/// the next iteration continues a search that ends here. No sweep.
inline constexpr Real max_scale = 2;

/// Numbers of iterations by tangents (25), then by secants (24). Later iterations keep the impedance of
/// friction, so that an unfinished search adds no energy. Tolerances are shares of the largest normal force.
struct FrictionAgainstTheWorld {
  static constexpr bool tangents = true;
  static constexpr int by_tangent = 4, by_secant = 2;
  static constexpr Real min_friction_change = 0;
  // no wider: position errors of the reference scene `press` increase above this tolerance
  // (tests/core/contact/test_reference.cc)
  static constexpr Real friction_tolerance(int) noexcept { return 1e-6; }
  static constexpr Real normal_tolerance(int iteration) noexcept { return friction_tolerance(iteration); }
};
/// Search for friction among bodies, without tangents.
struct FrictionAmongBodies {
  static constexpr bool tangents = false;
  static constexpr int by_tangent = 0, by_secant = 5;
  // smaller changes of friction are skipped in the next iteration, so that less is factored again
  static constexpr Real min_friction_change = 1e-5;
  // Lasting contacts converge in two iterations, and then to the end, because missing friction accelerates
  // slipping bodies (bodies/test_laws.cc). Collisions of many bodies take more iterations with wider
  // tolerances. bodies/test_stability.cc limits them.
  static constexpr Real friction_tolerance(int iteration) noexcept {
    return iteration > 3 ? 3e-3 * static_cast<Real>(1 << (iteration - 1)) : 1e-5;
  }
  static constexpr Real normal_tolerance(int iteration) noexcept {
    return std::min(Real(3e-3) * static_cast<Real>(1 << (iteration > 1 ? iteration - 1 : 0)), Real(12e-3));
  }
};

/// Search for friction on nets. Nodes are many and light, so a friction residual moves none of them far.
/// tests/core/net/test_stability.cc.
struct FrictionOnNets : FrictionAmongBodies {
  static constexpr Real min_friction_change = 1e-3;
  static constexpr Real friction_tolerance(int iteration) noexcept { return normal_tolerance(iteration); }
};

// Contacts between nets. tests/core/net/test_faces.cc.

/// Contacts of a node with faces at a time, on each net in directions at least 60 degrees apart: between two
/// layers, or in a fold. Further ones are reported as contacts without room.
inline constexpr std::uint32_t max_faces_of_node = 8;
/// Candidates among which the contacts of a node with a net are selected; further ones are reported likewise.
inline constexpr std::size_t max_face_candidates = 64;
/// Weight, outside a face, up to which a path crosses the face: paths between two faces cross at least one.
inline constexpr Real face_rim = 0.02;
/// Share of the thickness: a node that was deeper keeps its side of the surface, without a test of its path.
inline constexpr Real kept_side_depth = 0.5;

// Springs of nets. tests/core/net/test_stability.cc.

/// Limit of a gain of spring energy, as a share of the energy that springs exchange in a stage (46). Pressed
/// nets gain up to 0.03, diverging ones 0.17 and more.
inline constexpr Real max_spring_gain = 0.05;

/// Limit of the returned angular momentum (48), as a share of the possible one at these speeds. A step that
/// changes more does not resolve the rotation of its springs; returning it may gain energy. The same tests.
inline constexpr Real max_given_back = 0.05;

// Conjugate gradients (28), for systems with too few blocks. test_few_blocks.cc.

/// Tolerance of all velocities at the end of the iterations, m/s.
inline constexpr Real velocity_tolerance = 1e-3;
/// Limits of iterations of conjugate gradients in a Newton iteration: few before friction has converged.
inline constexpr int max_cg_iterations_searching = 3, max_cg_iterations = 8;
/// Strips in which the nodes of a carrier are put into groups of four, so that two groups do not wait for
/// each other. Of 2, 4, 6, 8, 16 and 32, steps of S6 are shortest with 8, by up to 7 %. docs/decisions/059.
inline constexpr std::uint32_t node_strips = 8;
/// Nodes examined to fill a group: more than a node has neighbours. No sweep.
inline constexpr std::size_t nodes_looked_ahead = 64;

/// Divisor: a Newton iteration of a system with nets may take this share of the remaining iterations.
/// Contacts may change their modes, and the next one needs some. tests/core/net/test_stability.cc.
inline constexpr int net_iteration_divisor = 2;

// Gaps in a device's samples (core/device). tests/core/contact/test_sample_gaps.cc; docs/decisions/026.

/// Steps without a valid sample that are bridged, for a late answer or an outlier. The target continues its
/// motion.
inline constexpr int bridged_steps = 3;
/// Time after a longer gap, s. The feedback stays constant for it (or the ramp, if longer) and grows during
/// as much again. The softest of the swept couplings catches up in it.
inline constexpr Real after_gap = 0.25;
/// Longest gap over which a gripped body stays gripped, s: the ramp corrects its motion in that time.
inline constexpr Real max_gap_with_grip = 0.1;
/// After a bridged gap the feedback may not grow for this multiple of the gap. Meanwhile the bridge's error
/// decays in the coupling, to 3 %.
inline constexpr Real recovery_per_gap = 30;

// Energy balance (38). tests/platform/session/test_energy_gained.cc, test_attack_scenes.cc,
// tests/core/contact/test_energy_of_contacts.cc; docs/decisions/039.

/// Allowed gain within the window, as a share of the energy at work. Smaller gains are errors of second
/// order.
inline constexpr Real gain_allowed = 0.01;
/// Smaller gains are ignored, J: below perception of a hand.
inline constexpr Real gain_floor = 1e-12;
/// Multiple of the available energy (58). A step that ends with more kinetic energy is a failed solve. Work
/// within its bounds reaches 2; errors of any order stay far below the rest. tests/core/test_energy_rise.cc.
inline constexpr Real max_rise = 10;
/// Share of the energy of net springs below which gains are ignored. Their iteration and contact forces end
/// at a tolerance, so a pressed net moves back and forth by it. tests/core/net/test_stability.cc.
inline constexpr Real net_gain_floor = 1e-3;
/// Steps for which a loss or gain must last to count. With a step too long for a collision or a snapping
/// joint, energy errs to either side, and the next steps correct it.
inline constexpr std::size_t gain_steps = 8;
/// Longest time over which gains are remembered, s. At least half of it is remembered.
inline constexpr Real gain_window = 1;

// Rounding tolerances in checks of parameters and inputs, and in geometry. Far above the rounding of a
// double, far below perception and the solver's tolerances. Not chosen by a sweep.

/// Tolerance of |q|^2 - 1 of quaternions in a scene. In a sample it is twice as much. The length differs by
/// half of it.
inline constexpr Real quaternion_tolerance = 1e-6;
/// Tolerance of the geometry of a scene: distance of a joint frame from a rotation, asymmetric share of an
/// inertia. Also height of a degenerate triangle per longest edge, and length of normals that cancel. Also
/// difference of depths at an edge of two faces, per radius of a node.
inline constexpr Real input_tolerance = 1e-9;
/// Share of a sum up to which it is rounding: 1 + z . u of opposite axes, distance from a triangle per its
/// size, V^T A V of the deformation of a net (45), E (38).
inline constexpr Real rounding_share = 1e-12;
/// Length below which a vector has no direction, m, because its square leaves the range of normal numbers.
inline constexpr Real min_length = 1e-150;
/// Squared radius of the sphere round a cell, in edges of the cell: (sqrt(3) / 2)^2, plus rounding.
inline constexpr Real cell_radius_sq = 0.75001;

}  // namespace godobject
