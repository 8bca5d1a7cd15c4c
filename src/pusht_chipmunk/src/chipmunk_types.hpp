// SPDX-License-Identifier: BSD-3-Clause
/// Chipmunk's vectors and objects beside Eigen's and C++'s, and what a process does before it uses any.
#pragma once

#include <chipmunk/chipmunk.h>

#include <Eigen/Core>
#include <memory>

namespace pusht {

inline cpVect toChipmunk(const Eigen::Vector2d& vector) { return cpv(vector.x(), vector.y()); }
inline Eigen::Vector2d toEigen(const cpVect& vector) { return {vector.x, vector.y}; }

struct FreeOfChipmunk {
  void operator()(cpSpace* space) const { cpSpaceFree(space); }
  void operator()(cpBody* body) const { cpBodyFree(body); }
  void operator()(cpShape* shape) const { cpShapeFree(shape); }
  void operator()(cpConstraint* constraint) const { cpConstraintFree(constraint); }
};

/// Object of Chipmunk that its owner frees. A space looks at its bodies when it is freed: it must go first.
template <class T>
using Owned = std::unique_ptr<T, FreeOfChipmunk>;

/// Makes Chipmunk ready: Debian's greets on stdout, where results belong, when a process makes its first space.
void prepareChipmunk();

}  // namespace pusht
