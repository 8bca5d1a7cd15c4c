// SPDX-License-Identifier: BSD-3-Clause
#include "rigid_body_solver.hpp"

#include <cmath>
#include <limits>

namespace pusht::rigid_body {
namespace {

/// Force of a row at a missing acceleration, and which limit it is held at.
struct RowForce {
  double force;  ///< [N]
  bool below;
  bool above;

  RowForce(const Row& row, double missing) : force(row.stiffness * missing) {
    below = force < row.least;
    above = force > row.greatest;
    force = below ? row.least : (above ? row.greatest : force);
  }

  bool isFree() const { return !below && !above; }
};

/// The minimized function along a line of accelerations: a step of 0 is the current one, 1 a whole Newton step.
struct Line {
  const Rows& rows;
  std::array<double, Rows::kMost> missing;  ///< [m/s^2] acceleration of each row at step 0
  std::array<double, Rows::kMost> change;   ///< [m/s^2] change of it over a whole step
  double slope;                             ///< [W/s] without the rows, at step 0
  double curvature;                         ///< [W/s] without the rows

  explicit Line(const Rows& of) : rows(of) {}

  RowForce at(std::size_t row, double step) const { return {rows.rows[row], missing[row] + step * change[row]}; }

  /// Whether a whole step takes any row across one of its limits.
  bool bends() const {
    for (std::size_t r = 0; r < rows.count; ++r) {
      const RowForce before = at(r, 0.0);
      const RowForce after = at(r, 1.0);
      if (before.below != after.below || before.above != after.above) {
        return true;
      }
    }
    return false;
  }
};

/// Step at which the function on the line is least. Its slope is piecewise linear and rises, so Newton's method finds
/// the root if a bracket keeps it from cycling. `descent` is minus the slope at step 0.
double leastOn(const Line& line, double descent) {
  constexpr int kMostIterations = 60;
  constexpr double kPrecision = 1e-13;
  double step = 1.0;
  double low = 0.0;
  double high = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kMostIterations; ++i) {
    double slope = line.slope + step * line.curvature;
    double curvature = line.curvature;
    for (std::size_t r = 0; r < line.rows.count; ++r) {
      const RowForce at = line.at(r, step);
      slope += line.change[r] * at.force;
      if (at.isFree()) {
        curvature += line.rows.rows[r].stiffness * line.change[r] * line.change[r];
      }
    }
    if (!(std::abs(slope) > kPrecision * descent)) {
      break;
    }
    (slope < 0.0 ? low : high) = step;
    const double newton = step - slope / curvature;
    if (newton > low && newton < high) {
      step = newton;
    } else {
      step = std::isinf(high) ? 2.0 * step : 0.5 * (low + high);
    }
  }
  return step;
}

}  // namespace

Vector product(const Matrix& matrix, const Vector& vector) {
  Vector result;
  for (std::size_t i = 0; i < kCoordinateCount; ++i) {
    result[i] = dot(matrix[i], vector);
  }
  return result;
}

Vector solved(Matrix matrix, Vector right) {
  // L D L', in place.
  Vector inverse_diagonal;
  for (std::size_t j = 0; j < kCoordinateCount; ++j) {
    inverse_diagonal[j] = 1.0 / matrix[j][j];
    for (std::size_t i = j + 1; i < kCoordinateCount; ++i) {
      const double factor = matrix[i][j] * inverse_diagonal[j];
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

Vector constraintForce(const Matrix& mass, const Vector& force, const Rows& rows) {
  constexpr int kMostIterations = 100;
  Vector total = {};
  if (rows.count == 0) {
    return total;
  }
  Vector acceleration = solved(mass, force);
  bool bent = true;
  for (int i = 0; bent && i < kMostIterations; ++i) {
    // Forces of the rows, and the second derivative of the function.
    Line line(rows);
    Matrix hessian = mass;
    total = {};
    for (std::size_t r = 0; r < rows.count; ++r) {
      const Row& row = rows.rows[r];
      line.missing[r] = row.wanted - dot(row.jacobian, acceleration);
      const RowForce at(row, line.missing[r]);
      for (std::size_t j = 0; j < kCoordinateCount; ++j) {
        total[j] += row.jacobian[j] * at.force;
      }
      if (at.isFree()) {
        for (std::size_t j = 0; j < kCoordinateCount; ++j) {
          const double weight = row.stiffness * row.jacobian[j];
          for (std::size_t k = 0; k <= j; ++k) {
            hessian[j][k] += weight * row.jacobian[k];
          }
        }
      }
    }

    // Newton's direction.
    const Vector inertial = product(mass, acceleration);
    Vector downhill;
    for (std::size_t j = 0; j < kCoordinateCount; ++j) {
      downhill[j] = force[j] + total[j] - inertial[j];
    }
    const Vector direction = solved(hessian, downhill);

    // A whole step, or the least point on the way if a row bends.
    for (std::size_t r = 0; r < rows.count; ++r) {
      line.change[r] = -dot(rows.rows[r].jacobian, direction);
    }
    bent = line.bends();
    double step = 1.0;
    if (bent) {
      line.slope = dot(direction, inertial) - dot(direction, force);
      line.curvature = dot(direction, product(mass, direction));
      step = leastOn(line, dot(direction, downhill));
    }
    for (std::size_t j = 0; j < kCoordinateCount; ++j) {
      acceleration[j] += step * direction[j];
    }
  }

  total = {};
  for (const Row& row : rows) {
    const RowForce at(row, row.wanted - dot(row.jacobian, acceleration));
    for (std::size_t j = 0; j < kCoordinateCount; ++j) {
      total[j] += row.jacobian[j] * at.force;
    }
  }
  return total;
}

}  // namespace pusht::rigid_body
