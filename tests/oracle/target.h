// Motions of the targets of coupled bodies: a function of time, or a table of poses.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "tests/oracle/case/case.h"

namespace godobject::oracle {

/// A motion X_WD(t) with velocities that are the derivatives of its pose.
class Target {
 public:
  virtual ~Target() = default;

  virtual RigidState at(double t) const = 0;

  /// Ascending times at which the motion is not smooth; integration steps end there.
  virtual std::span<const double> knots() const { return {}; }
};

/// A motion in closed form. The function must return consistent velocities, and be smooth between the knots:
/// a step may be as long as the distance between them.
class FunctionTarget final : public Target {
 public:
  explicit FunctionTarget(std::function<RigidState(double t)> motion, std::vector<double> knots = {})
      : motion_(std::move(motion)), knots_(std::move(knots)) {}
  RigidState at(double t) const override { return motion_(t); }
  std::span<const double> knots() const override { return knots_; }

 private:
  std::function<RigidState(double t)> motion_;
  std::vector<double> knots_;
};

/// A motion known by its poses at given times. Between two samples each of the 3 + 4 pose numbers is the
/// quintic with the first and second derivatives there. These come from the polynomial through the 7 nearest
/// samples: at 1 ms a motion of a few Hz is met to rounding, in velocity too. (The cubic leaves an error of
/// h^3/125 of the fourth derivative in velocity, 1e-7 m/s or rad/s for the reference motions). The quaternion
/// is normalised after interpolation and w is the exact derivative of the result.
class TabulatedTarget final : public Target {
 public:
  /// times: strictly ascending, at least 2; p, q: as many; q need not keep its sign from row to row.
  /// Throws std::invalid_argument otherwise.
  TabulatedTarget(std::vector<double> times, const std::vector<Vector3d>& p,
                  const std::vector<Quaterniond>& q);

  /// Throws std::out_of_range outside the table.
  RigidState at(double t) const override;
  std::span<const double> knots() const override { return times_; }

 private:
  using Coordinates = Eigen::Matrix<double, 7, 1>;  // p, then q as w x y z

  struct Sample {
    Coordinates value = Coordinates::Zero();
    Coordinates d1 = Coordinates::Zero();  // 1/s
    Coordinates d2 = Coordinates::Zero();  // 1/s^2
  };

  void differentiate(std::size_t i);

  std::vector<double> times_;
  std::vector<Sample> samples_;
};

}  // namespace godobject::oracle
