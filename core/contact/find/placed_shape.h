// Shape in the world during a stage. Its pose is set as a whole, so that no part can be read unset.
#pragma once

#include "core/joint/tree.h"
#include "core/shape/list.h"
#include "core/shape/points.h"

namespace godobject {

/// Shape with its pose in the world; the quaternion and the matrix R_WS are one attitude.
class PlacedShape {
 public:
  PlacedShape() = default;
  /// in_world: its X_WS is the pose in the world.
  explicit PlacedShape(const ShapeParams& in_world) noexcept
      : in_world_(in_world), R_WS_(in_world.X_WS.q.toRotationMatrix()) {}
  /// on_body: its X_WS is the pose on the body. at: place of the body.
  PlacedShape(const ShapeParams& on_body, const TreePlace& at) noexcept
      : in_world_(on_body), R_WS_(at.R_WB * on_body.X_WS.q.toRotationMatrix()) {
    in_world_.X_WS = {.p = at.p_W + at.R_WB * on_body.X_WS.p, .q = Quat(at.R_WB) * on_body.X_WS.q};
  }

  ShapeKind kind() const noexcept { return in_world_.kind; }
  const Vec3& p_W() const noexcept { return in_world_.X_WS.p; }  // origin of its frame
  const Mat3& R_WS() const noexcept { return R_WS_; }
  const Vec3& half_extents() const noexcept { return in_world_.half_extents; }
  Real radius() const noexcept { return in_world_.radius; }
  Real half_length() const noexcept { return in_world_.half_length; }
  /// Returns the dimensions and the pose in the world.
  const ShapeParams& in_world() const noexcept { return in_world_; }

  /// Moves the shape and turns it about the origin of its frame.
  void move(const Vec3& way_W, const Quat& turn_W) noexcept {
    in_world_.X_WS = {.p = in_world_.X_WS.p + way_W, .q = turn_W * in_world_.X_WS.q};
    R_WS_ = turn_W.toRotationMatrix() * R_WS_;
  }

 private:
  ShapeParams in_world_;
  Mat3 R_WS_ = Mat3::Identity();
};

/// Returns half the extents of a shape on a body, about the origin of its frame.
inline Vec3 half_extents(const ShapeParams& shape) noexcept {
  if (shape.kind == ShapeKind::sphere) return Vec3::Constant(shape.radius);
  if (shape.kind == ShapeKind::capsule)
    return Vec3(shape.radius, shape.radius, shape.radius + shape.half_length);
  return shape.half_extents;
}

/// Returns the bounding radius of a bounded shape about the origin of its frame.
inline Real ball_round(const PlacedShape& shape) noexcept {
  return shape.kind() == ShapeKind::box ? shape.half_extents().norm() : shape.radius() + shape.half_length();
}

}  // namespace godobject
