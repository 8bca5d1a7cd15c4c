// SPDX-License-Identifier: BSD-3-Clause
// Constraint forces: closed forms, the conditions of a minimum, Eigen's decomposition.
#include "rigid_body_solver.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "rigid_body_testing.hpp"

namespace pusht::rigid_body {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

using EigenMatrix = Eigen::Matrix<double, kCoordinateCount, kCoordinateCount>;
using EigenVector = Eigen::Matrix<double, kCoordinateCount, 1>;

EigenVector eigen(const Vector& vector) { return Eigen::Map<const EigenVector>(vector.data()); }

EigenMatrix eigen(const Matrix& matrix) {
  EigenMatrix result;
  for (std::size_t i = 0; i < kCoordinateCount; ++i) {
    result.row(static_cast<Eigen::Index>(i)) = eigen(matrix[i]).transpose();
  }
  return result;
}

Matrix identity() {
  Matrix matrix = {};
  for (std::size_t i = 0; i < kCoordinateCount; ++i) {
    matrix[i][i] = 1.0;
  }
  return matrix;
}

Matrix anyMass(Random& random) {
  EigenMatrix root;
  for (double& number : root.reshaped()) {
    number = random(-1.0, 1.0);
  }
  const EigenMatrix mass = root * root.transpose() + 0.1 * EigenMatrix::Identity();
  Matrix result;
  for (std::size_t i = 0; i < kCoordinateCount; ++i) {
    for (std::size_t j = 0; j < kCoordinateCount; ++j) {
      result[i][j] = mass(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
    }
  }
  return result;
}

Vector anyVector(Random& random, double size) {
  Vector vector;
  for (double& number : vector) {
    number = random(-size, size);
  }
  return vector;
}

TEST(Solved, IsWhatEigenFinds) {
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const Matrix matrix = anyMass(random);
    const Vector right = anyVector(random, 3.0);
    const EigenVector expected = eigen(matrix).ldlt().solve(eigen(right));
    EXPECT_LT((eigen(solved(matrix, right)) - expected).norm(), 1e-10 * (1.0 + expected.norm()));
  }
}

TEST(ConstraintForce, OneRowHasAClosedForm) {
  // m = 1, pushed against a row of stiffness k that wants acceleration w: f = k (w - a), a = p + f.
  const double pull = -3.0;
  const double stiffness = 9.0;
  const double wanted = 2.0;
  Rows rows;
  rows.add({{1.0, 0.0, 0.0, 0.0, 0.0}, wanted, stiffness, 0.0, kInfinity});
  const Vector force = constraintForce(identity(), {pull, 0.0, 0.0, 0.0, 0.0}, rows);
  EXPECT_NEAR(force[0], stiffness * (wanted - pull) / (1.0 + stiffness), 1e-14);
  EXPECT_EQ(force[1], 0.0);
}

TEST(ConstraintForce, StopsAtItsLimits) {
  Rows rows;
  rows.add({{1.0, 0.0, 0.0, 0.0, 0.0}, 0.0, 1e3, -1.2, 1.2});
  EXPECT_DOUBLE_EQ(constraintForce(identity(), {5.0, 0.0, 0.0, 0.0, 0.0}, rows)[0], -1.2);
  EXPECT_NEAR(constraintForce(identity(), {1.0, 0.0, 0.0, 0.0, 0.0}, rows)[0], -1.0 * 1e3 / (1e3 + 1.0), 1e-14);
}

TEST(ConstraintForce, WithoutRowsThereIsNone) {
  EXPECT_EQ(constraintForce(identity(), {1.0, 0.0, 0.0, 0.0, 0.0}, {}), (Vector{}));
}

Rows anyRows(Random& random, int count) {
  Rows rows;
  for (int i = 0; i < count; ++i) {
    const bool two_sided = random.flip();
    const double limit = two_sided ? random(0.1, 3.0) : kInfinity;
    rows.add(
        {anyVector(random, 1.0), random(-20.0, 20.0), std::exp(random(-3.0, 12.0)), two_sided ? -limit : 0.0, limit});
  }
  return rows;
}

/// At the minimum M a = f + J' force, with every force what its row gives at a.
TEST(ConstraintForce, IsAtTheMinimum) {
  Random random(2);
  for (int i = 0; i < 3000; ++i) {
    const Matrix mass = anyMass(random);
    const Vector pull = anyVector(random, 10.0);
    const Rows rows = anyRows(random, 1 + i % 20);
    const Vector force = constraintForce(mass, pull, rows);
    const EigenVector acceleration = eigen(mass).ldlt().solve(eigen(pull) + eigen(force));
    EigenVector expected = EigenVector::Zero();
    double largest = 1.0;
    for (const Row& row : rows) {
      const double missing = row.wanted - eigen(row.jacobian).dot(acceleration);
      expected += std::clamp(row.stiffness * missing, row.least, row.greatest) * eigen(row.jacobian);
      largest = std::max(largest, row.stiffness);
    }
    // Rounding of the acceleration, magnified by the stiffest row and by the condition of the matrices.
    EXPECT_LT((eigen(force) - expected).norm(), 1e-8 * largest * (1.0 + expected.norm())) << "case " << i;
  }
}

}  // namespace
}  // namespace pusht::rigid_body
