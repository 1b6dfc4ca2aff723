#include "platform/scene/joint/joints.h"

#include <algorithm>
#include <vector>

#include <Eigen/QR>

namespace godobject {
namespace {

std::size_t index_of(std::span<const BodyConfig> bodies, const std::string& name) {
  const auto found = std::ranges::find(bodies, name, &BodyConfig::name);
  return found == bodies.end() ? world : static_cast<std::size_t>(found - bodies.begin());
}

JointFrames frames_at_start(std::span<const BodyConfig> bodies, const JointConfig& joint) {
  const std::size_t parent = index_of(bodies, joint.parent);
  const Pose X_WP = parent == world ? Pose{} : bodies[parent].X_WB;
  const Pose& X_WC = bodies[index_of(bodies, joint.child)].X_WB;
  return {.R_WP = (X_WP.q * joint.X_BP.q).toRotationMatrix(),
          .R_WC = (X_WC.q * joint.X_BC.q).toRotationMatrix(),
          .d_W = X_WC.p + X_WC.q * joint.X_BC.p - X_WP.p - X_WP.q * joint.X_BP.p};
}

}  // namespace

JointParams joint_params(std::span<const BodyConfig> bodies, const JointConfig& joint) {
  return {.kind = joint.kind,
          .parent = index_of(bodies, joint.parent),
          .P = joint_frame(joint.X_BP),
          .C = joint_frame(joint.X_BC)};
}

JointGap gap_at_start(std::span<const BodyConfig> bodies, const JointConfig& joint) {
  const JointFrames X = frames_at_start(bodies, joint);
  JointGap gap{.m = 0, .rad = angular_gap(joint.kind, X)};
  with_joint(joint.kind, [&](auto kind) { gap.m = decltype(kind)::motion(X).e_v.norm(); });
  return gap;
}

namespace {

/// Places the child of the joint of body i again, if `moves` is true, and with its parent otherwise.
/// coordinates(kind, X): those that it gets, X the frames found.
template <class Moves, class Coordinates>
void place_again(std::span<BodyConfig> bodies, std::span<const JointConfig> joints, Moves moves,
                 Coordinates coordinates) {
  const std::vector<BodyConfig> placed(bodies.begin(), bodies.end());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const auto joint = std::ranges::find(joints, bodies[i].name, &JointConfig::child);
    if (joint == joints.end()) continue;
    Pose& X = bodies[i].X_WB;
    const std::size_t parent = index_of(bodies, joint->parent);
    if (parent < i) {
      // moves with its parent
      const Pose &from = placed[parent].X_WB, &to = bodies[parent].X_WB;
      if (from.p != to.p || from.q.coeffs() != to.q.coeffs()) {
        const Quat turn = (to.q * from.q.conjugate()).normalized();
        X = {.p = to.p + turn * (X.p - from.p), .q = (turn * X.q).normalized()};
      }
    }
    if (!moves(*joint)) continue;
    const JointFrames found = frames_at_start(bodies, *joint);
    with_joint(joint->kind, [&](auto kind) {
      using Kind = decltype(kind);
      JointFrames held = found;  // frame of the parent at the child's coordinates
      if constexpr (requires { Kind::coordinates(found); })
        held = Kind::at(found, coordinates(*joint, Kind::coordinates(found)));
      const Quat turn(Mat3(held.R_WP * found.R_WC.transpose()));
      const Vec3 anchor = X.p + X.q * joint->X_BC.p - held.d_W;
      if (!is_ball(joint->kind)) X.q = (turn * X.q).normalized();
      X.p = anchor - X.q * joint->X_BC.p;
    });
  }
}

}  // namespace

void close_gaps(std::span<BodyConfig> bodies, std::span<const JointConfig> joints) {
  place_again(
      bodies, joints, [&](const JointConfig& joint) { return is_apart(gap_at_start(bodies, joint)); },
      [](const JointConfig&, const JointCoordinates& q) { return q; });
}

void place_children(std::span<BodyConfig> bodies, std::span<const JointConfig> joints) {
  place_again(
      bodies, joints,
      [&](const JointConfig& joint) {
        const bool is_placed = std::ranges::find(bodies, joint.child, &BodyConfig::name)->is_placed;
        return !is_placed && (joint.start[0] || joint.start[1]);
      },
      [](const JointConfig& joint, const JointCoordinates& q) {
        return JointCoordinates(joint.start[0].value_or(q[0]), joint.start[1].value_or(q[1]));
      });
}

JointCoordinates coordinates_at_start(std::span<const BodyConfig> bodies, const JointConfig& joint) {
  const JointFrames X = frames_at_start(bodies, joint);
  JointCoordinates q = JointCoordinates::Zero();
  with_joint(joint.kind, [&](auto kind) {
    using Kind = decltype(kind);
    if constexpr (requires { Kind::coordinates(X); }) q = Kind::coordinates(X);
  });
  for (std::size_t c = 0; c < joint.coordinates.size(); ++c) {
    if (!is_turn(joint.kind, c)) continue;
    Real& angle = q[static_cast<Eigen::Index>(c)];
    const auto stop = std::ranges::find(joint.stops, joint.coordinates[c], &StopConfig::coordinate);
    if (joint.start[c]) angle = unwrapped(angle, *joint.start[c]);
    else if (stop != joint.stops.end()) angle = start_coordinate(stop->params, angle);
  }
  return q;
}

namespace {

/// Rows of constraints over the coordinates of all joints, those of free bodies included.
class ConstraintRows {
 public:
  explicit ConstraintRows(const SceneConfig& scene) : scene_(scene) {
    for (const BodyConfig& body : scene.bodies) {
      const JointConfig* const joint = joint_of(body.name);
      first_.push_back(size_);
      const NumAxes n = joint ? num_axes(joint->kind) : NumAxes{.turns = 3, .slides = 3};
      size_ += joint && joint->prescribed ? 0 : n.turns + n.slides;
    }
  }

  Eigen::Index size() const { return size_; }
  const Eigen::MatrixXd& rows() const { return rows_; }

  /// Adds the rows of a closing joint.
  void add(const JointConfig& loop) {
    const JointFrames X = frames_at_start(scene_.bodies, loop);
    const Pose& X_WC = scene_.bodies[index_of(scene_.bodies, loop.child)].X_WB;
    const Vec3 anchor = X_WC.p + X_WC.q * loop.X_BC.p;
    const Eigen::MatrixXd twist = twist_of(loop.child, anchor) - twist_of(loop.parent, anchor);
    with_joint(loop.kind, [&](auto kind) {
      const auto m = kind.motion(X);
      Mat3 turns = Mat3::Identity(), moves = Mat3::Identity();
      if constexpr (decltype(m)::num_turns == 3) turns.setZero();
      for (const Vec3& s : m.turn) turns -= s * s.transpose();
      for (const Vec3& s : m.slide) moves -= s * s.transpose();
      append(turns * twist.topRows(3), 3 - decltype(m)::num_turns);
      append(moves * twist.bottomRows(3), 3 - decltype(m)::num_slides);
    });
  }
  /// Adds the row of a rigid gear.
  void add(const GearConfig& gear) {
    Eigen::MatrixXd row = Eigen::MatrixXd::Zero(1, size_);
    const auto set = [&](const std::string& name, double share) {
      const CoordinateOfJoint q = coordinate_named(scene_, name);
      if (!q.joint->prescribed)
        row(0, first_[index_of(scene_.bodies, q.joint->child)] + static_cast<Eigen::Index>(q.number)) = share;
    };
    set(gear.a, -gear.ratio);
    set(gear.b, 1);
    append(row, 1);
  }
  std::size_t num_constraints() const { return num_constraints_; }

 private:
  const JointConfig* joint_of(const std::string& body) const {
    const auto joint = std::ranges::find(scene_.joints, body, &JointConfig::child);
    return joint == scene_.joints.end() ? nullptr : &*joint;
  }

  /// Returns the twist at a point of a body by all coordinates, rotations first.
  Eigen::MatrixXd twist_of(std::string body, const Vec3& p_W) const {
    Eigen::MatrixXd twist = Eigen::MatrixXd::Zero(6, size_);
    while (body != world_name) {
      const std::size_t i = index_of(scene_.bodies, body);
      Eigen::Index column = first_[i];
      const auto turn = [&](const Vec3& s, const Vec3& anchor) {
        twist.col(column++) << s, s.cross(p_W - anchor);
      };
      const auto slide = [&](const Vec3& s) { twist.col(column++) << Vec3::Zero(), s; };
      const JointConfig* const joint = joint_of(body);
      if (joint == nullptr) {
        for (int k = 0; k < 3; ++k) turn(Vec3::Unit(k), scene_.bodies[i].X_WB.p);
        for (int k = 0; k < 3; ++k) slide(Vec3::Unit(k));
        return twist;
      }
      const Vec3 anchor = scene_.bodies[i].X_WB.p + scene_.bodies[i].X_WB.q * joint->X_BC.p;
      with_joint(joint->kind, [&](auto kind) {
        if (joint->prescribed) return;
        const auto m = kind.motion(frames_at_start(scene_.bodies, *joint));
        if constexpr (decltype(m)::num_turns == 3)
          for (int k = 0; k < 3; ++k) turn(Vec3::Unit(k), anchor);
        for (const Vec3& s : m.turn) turn(s, anchor);
        for (const Vec3& s : m.slide) slide(s);
      });
      body = joint->parent;
    }
    return twist;
  }

  void append(const Eigen::MatrixXd& rows, int num) {
    num_constraints_ += static_cast<std::size_t>(num);
    rows_.conservativeResize(rows_.rows() + rows.rows(), size_);
    rows_.bottomRows(rows.rows()) = rows;
  }

  const SceneConfig& scene_;
  std::vector<Eigen::Index> first_;  // coordinate of each body
  Eigen::Index size_ = 0;
  Eigen::MatrixXd rows_;
  std::size_t num_constraints_ = 0;
};

}  // namespace

Mobility mobility_at_start(const SceneConfig& scene) {
  ConstraintRows all(scene);
  for (const JointConfig& loop : scene.loops) all.add(loop);
  for (const GearConfig& gear : scene.gears)
    if (!gear.stiffness) all.add(gear);
  Mobility mobility{.num_freedoms = static_cast<std::size_t>(all.size()),
                    .num_constraints = all.num_constraints()};
  if (all.rows().size() == 0) return mobility;
  constexpr double negligible = 1e-9;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(all.rows());
  qr.setThreshold(negligible);
  const auto rank = static_cast<std::size_t>(qr.rank());
  mobility.num_freedoms -= rank;
  mobility.num_redundant = mobility.num_constraints - rank;
  return mobility;
}

}  // namespace godobject
