// SPDX-License-Identifier: BSD-3-Clause
/// Numbers of several worlds at once, so that one text of the physics serves one world (double) and many (Lanes).
/// Every operation follows IEEE 754 in each lane, so a lane has the bits of a single world.
#pragma once

#include <Eigen/Core>
#include <experimental/simd>
#include <type_traits>

namespace pusht::simd {

constexpr int kLaneCount = 8;  ///< worlds in one Lanes: enough to hide the latency of a division
using Lanes = std::experimental::fixed_size_simd<double, kLaneCount>;

/// `a` where `condition` holds, else `b`.
inline double select(bool condition, double a, double b) { return condition ? a : b; }
/// Per lane: `a` where `condition` holds, else `b`.
inline Lanes select(const Lanes::mask_type& condition, const Lanes& a, Lanes b) {
  std::experimental::where(condition, b) = a;
  return b;
}

/// Whether a condition holds in any world.
inline bool any(bool condition) { return condition; }
/// Whether a condition holds in any lane.
inline bool any(const Lanes::mask_type& condition) { return std::experimental::any_of(condition); }

/// Result of a comparison: one truth value for each world.
template <class Real>
using Condition = decltype(Real() < Real());

// Lanes bring an alignment of their own.
template <class Real>
using Vector2 = Eigen::Matrix<Real, 2, 1, std::is_same_v<Real, double> ? Eigen::AutoAlign : Eigen::DontAlign>;

/// Factor times vector. (Eigen's own operators would give Lanes an alignment that is less than they need.)
template <class Real>
[[gnu::always_inline]] inline Vector2<Real> scaled(const Real& factor, const Vector2<Real>& vector) {
  return Vector2<Real>(factor * vector.x(), factor * vector.y());
}

}  // namespace pusht::simd

/// \cond Doxygen knows no namespace of another library.
/// Traits that Eigen needs of a number type, by Eigen's names.
// NOLINTBEGIN(readability-identifier-naming)
template <>
struct Eigen::NumTraits<pusht::simd::Lanes> : Eigen::GenericNumTraits<pusht::simd::Lanes> {
  enum {
    IsComplex = 0,
    IsInteger = 0,
    IsSigned = 1,
    RequireInitialization = 0,
    ReadCost = 1,
    AddCost = 1,
    MulCost = 1
  };
};
// NOLINTEND(readability-identifier-naming)
/// \endcond
