// SPDX-License-Identifier: BSD-3-Clause
/// Constraint forces as the minimum of a convex function, as MuJoCo has them. For one world or many.
/// Source: E. Todorov, "Convex and analytically-invertible dynamics with contacts and constraints" (ICRA 2014).
#pragma once

#include <array>
#include <cstddef>
#include <limits>

#include "pusht_engine/rigid_body_model.hpp"
#include "pusht_engine/simd.hpp"

namespace pusht::rigid_body {

using simd::any;
using simd::Condition;
using simd::scaled;
using simd::select;
using simd::Vector2;

template <class Real>
using Vector = std::array<Real, kCoordinateCount>;
template <class Real>
using Matrix = std::array<Vector<Real>, kCoordinateCount>;

template <class Real>
Real dot(const Vector<Real>& a, const Vector<Real>& b) {
  Real sum = a[0] * b[0];
  for (std::size_t i = 1; i < kCoordinateCount; ++i) {
    sum += a[i] * b[i];
  }
  return sum;
}

template <class Real>
Vector<Real> product(const Matrix<Real>& matrix, const Vector<Real>& vector) {
  Vector<Real> result;
  for (std::size_t i = 0; i < kCoordinateCount; ++i) {
    result[i] = dot<Real>(matrix[i], vector);
  }
  return result;
}

/// x of `matrix` x = `right`. The matrix is symmetric and positive definite; only its lower half is read.
template <class Real>
Vector<Real> solved(Matrix<Real> matrix, Vector<Real> right) {
  // L D L', in place.
  Vector<Real> inverse_diagonal;
  for (std::size_t j = 0; j < kCoordinateCount; ++j) {
    inverse_diagonal[j] = 1.0 / matrix[j][j];
    for (std::size_t i = j + 1; i < kCoordinateCount; ++i) {
      const Real factor = matrix[i][j] * inverse_diagonal[j];
      for (std::size_t k = j + 1; k <= i; ++k) {
        matrix[i][k] -= factor * matrix[k][j];
      }
      right[i] -= factor * right[j];
    }
  }
  for (std::size_t j = kCoordinateCount; j-- > 0;) {
    for (std::size_t i = j + 1; i < kCoordinateCount; ++i) {
      right[j] -= matrix[i][j] * right[i];
    }
    right[j] *= inverse_diagonal[j];
  }
  return right;
}

/// One direction in which a constraint pushes. Its force is stiffness times the acceleration that is missing, within
/// limits.
template <class Real>
struct Row {
  Condition<Real> present;  ///< elsewhere the rest says nothing
  Vector<Real> jacobian;    ///< acceleration along the row, per acceleration of each coordinate
  Real wanted;              ///< [m/s^2] acceleration
  Real stiffness;           ///< [kg]
  Real least;               ///< [N]
  Real greatest;            ///< [N]
};

/// Dry friction on three coordinates; with friction three rows for each contact: of the pusher with two boxes and four
/// walls, of four corners of two boxes with four walls. (In several worlds at once all may be there.)
constexpr std::size_t kMostRows = 3 + 3 * (2 + 4 + 4 * 2 * 4);

template <class Real>
struct Rows {
  std::array<Row<Real>, kMostRows> rows;
  std::size_t count = 0;

  void add(const Row<Real>& row) { rows[count++] = row; }
  const Row<Real>* begin() const { return rows.data(); }
  const Row<Real>* end() const { return rows.data() + count; }
};

/// The force of a row at which the acceleration `missing` is missing, and whether it is within the limits.
template <class Real>
struct RowForce {
  Real force;
  Condition<Real> below;
  Condition<Real> above;

  RowForce(const Row<Real>& row, const Real& missing) : force(row.stiffness * missing) {
    below = force < row.least;
    above = force > row.greatest;
    force = select(below, row.least, select(above, row.greatest, force));
  }

  Condition<Real> free() const { return !below && !above; }
};

/// The potential of the rows along a line of accelerations.
template <class Real>
struct Line {
  const Rows<Real>& rows;
  std::array<Real, kMostRows> missing;  ///< [m/s^2] acceleration of each row at its begin
  std::array<Real, kMostRows> change;   ///< of that, for a whole step
  Real slope;                           ///< [W/s] of the rest of the function, at its begin
  Real curvature;

  /// Nothing else is set: most rows are not there.
  explicit Line(const Rows<Real>& of) : rows(of) {}

  RowForce<Real> at(std::size_t row, const Real& step) const {
    return RowForce<Real>(rows.rows[row], missing[row] + step * change[row]);
  }

  /// Whether a whole step takes any row across one of its limits.
  Condition<Real> bends() const {
    Condition<Real> result(false);
    for (std::size_t r = 0; r < rows.count; ++r) {
      const RowForce<Real> before = at(r, Real(0.0));
      const RowForce<Real> after = at(r, Real(1.0));
      result = result || (rows.rows[r].present && (before.below != after.below || before.above != after.above));
    }
    return result;
  }
};

/// Where on the line the function is least, in the worlds that are `searching`. Its slope is piecewise linear and
/// rises, so Newton's method finds the root, if a bracket keeps it from cycling. `descent` is minus the slope at the
/// begin.
template <class Real>
Real leastOn(const Line<Real>& line, const Real& descent, Condition<Real> searching) {
  constexpr int kMostIterations = 60;
  constexpr double kPrecision = 1e-13;
  Real step(1.0);
  Real low(0.0);
  Real high(std::numeric_limits<double>::infinity());
  for (int i = 0; i < kMostIterations && any(searching); ++i) {
    Real slope = line.slope + step * line.curvature;
    Real curvature = line.curvature;
    for (std::size_t r = 0; r < line.rows.count; ++r) {
      const Row<Real>& row = line.rows.rows[r];
      const RowForce<Real> at = line.at(r, step);
      slope = select(row.present, slope + line.change[r] * at.force, slope);
      const Real more = curvature + row.stiffness * line.change[r] * line.change[r];
      curvature = select(row.present && at.free(), more, curvature);
    }
    const Condition<Real> falls = slope < 0.0;
    searching = searching && select(falls, -slope, slope) > kPrecision * descent;
    low = select(searching && falls, step, low);
    high = select(searching && !falls, step, high);
    const Real newton = step - slope / curvature;
    const Real halved = select(high < std::numeric_limits<double>::max(), 0.5 * (low + high), 2.0 * step);
    step = select(searching, select(newton > low && newton < high, newton, halved), step);
  }
  return step;
}

/// [N, N m] The forces of all rows on the coordinates, at the acceleration a that minimises 1/2 a' M a - a' f plus the
/// potentials of the rows, where `mass` is M and `force` is f. By Newton's method. It ends when a whole step leaves
/// each row on the side of its limits where it was: then the minimum is exact.
template <class Real>
Vector<Real> constraintForce(const Matrix<Real>& mass, const Vector<Real>& force, const Rows<Real>& rows) {
  constexpr int kMostIterations = 100;
  const Real zero(0.0);
  Vector<Real> total = {zero, zero, zero, zero, zero};
  Condition<Real> searching(false);
  for (const Row<Real>& row : rows) {
    searching = searching || row.present;
  }
  if (!any(searching)) {
    return total;
  }
  Vector<Real> acceleration = solved<Real>(mass, force);
  for (int i = 0; any(searching) && i < kMostIterations; ++i) {
    Line<Real> line(rows);
    Matrix<Real> hessian = mass;
    total = {zero, zero, zero, zero, zero};
    for (std::size_t r = 0; r < rows.count; ++r) {
      const Row<Real>& row = rows.rows[r];
      line.missing[r] = row.wanted - dot<Real>(row.jacobian, acceleration);
      const RowForce<Real> at(row, line.missing[r]);
      const Condition<Real> bends = row.present && at.free();
      for (std::size_t j = 0; j < kCoordinateCount; ++j) {
        total[j] = select(row.present, total[j] + row.jacobian[j] * at.force, total[j]);
        const Real weight = row.stiffness * row.jacobian[j];
        for (std::size_t k = 0; k <= j; ++k) {
          hessian[j][k] = select(bends, hessian[j][k] + weight * row.jacobian[k], hessian[j][k]);
        }
      }
    }
    const Vector<Real> inertial = product<Real>(mass, acceleration);
    Vector<Real> downhill;
    for (std::size_t j = 0; j < kCoordinateCount; ++j) {
      downhill[j] = force[j] + total[j] - inertial[j];
    }
    const Vector<Real> direction = solved<Real>(hessian, downhill);

    for (std::size_t r = 0; r < rows.count; ++r) {
      line.change[r] = -dot<Real>(rows.rows[r].jacobian, direction);
    }
    const Condition<Real> bent = searching && line.bends();
    Real step(1.0);
    if (any(bent)) {
      line.slope = dot<Real>(direction, inertial) - dot<Real>(direction, force);
      line.curvature = dot<Real>(direction, product<Real>(mass, direction));
      step = select(bent, leastOn<Real>(line, dot<Real>(direction, downhill), bent), step);
    }
    for (std::size_t j = 0; j < kCoordinateCount; ++j) {
      acceleration[j] = select(searching, acceleration[j] + step * direction[j], acceleration[j]);
    }
    searching = bent;
  }

  total = {zero, zero, zero, zero, zero};
  for (const Row<Real>& row : rows) {
    const RowForce<Real> at(row, row.wanted - dot<Real>(row.jacobian, acceleration));
    for (std::size_t j = 0; j < kCoordinateCount; ++j) {
      total[j] = select(row.present, total[j] + row.jacobian[j] * at.force, total[j]);
    }
  }
  return total;
}

}  // namespace pusht::rigid_body
