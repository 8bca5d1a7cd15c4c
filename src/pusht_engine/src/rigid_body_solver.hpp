// SPDX-License-Identifier: BSD-3-Clause
/// Constraint forces of the rigid-body engine, as the minimum of a convex function.
/// Source: E. Todorov, "Convex and analytically-invertible dynamics with contacts and constraints" (ICRA 2014).
#pragma once

#include <array>
#include <cstddef>

#include "pusht_engine/rigid_body_model.hpp"
#include "rigid_body_contacts.hpp"

namespace pusht::rigid_body {

/// Matrix over the generalized coordinates.
using Matrix = std::array<Vector, kCoordinateCount>;

/// Sum of the products of the elements, in index order.
inline double dot(const Vector& a, const Vector& b) {
  double sum = a[0] * b[0];
  for (std::size_t i = 1; i < kCoordinateCount; ++i) {
    sum += a[i] * b[i];
  }
  return sum;
}

/// Product of a matrix and a vector; each sum is in the order of the index.
Vector product(const Matrix& matrix, const Vector& vector);

/// Solution x of `matrix` x = `right`. The matrix must be symmetric and positive definite; only its lower half is read.
Vector solved(Matrix matrix, Vector right);

/// One direction in which a constraint pushes. Its force is the stiffness times the missing acceleration (wanted less
/// actual), within limits.
struct Row {
  Vector jacobian;   ///< acceleration along the row per acceleration of each coordinate
  double wanted;     ///< [m/s^2] acceleration
  double stiffness;  ///< [kg]
  double least;      ///< [N]
  double greatest;   ///< [N]
};

/// Rows of a world: Coulomb friction on three coordinates, up to three rows for each contact.
struct Rows {
  static constexpr std::size_t kMost = 3 + 3 * Contacts::kMost;

  std::array<Row, kMost> rows;  ///< valid are the first `count`
  std::size_t count = 0;

  Rows() {}  // NOLINT(modernize-use-equals-default): leaves the array as it is
  void add(const Row& row) { rows[count++] = row; }
  const Row* begin() const { return rows.data(); }
  const Row* end() const { return rows.data() + count; }
};

/// [N, N m] Forces of all rows on the coordinates, at the acceleration a that minimizes 1/2 a' M a - a' f plus the
/// potentials of the rows, where `mass` is M and `force` is f. Newton's method: it ends when a whole step leaves each
/// row on the side of its limits where it was; then the minimum is exact.
Vector constraintForce(const Matrix& mass, const Vector& force, const Rows& rows);

}  // namespace pusht::rigid_body
