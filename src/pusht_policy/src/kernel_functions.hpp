// SPDX-License-Identifier: BSD-3-Clause
/// Functions of one number that the kernel has of its own: double operations in a fixed order, rounded to float once.
#pragma once

#include "pusht_policy/network_kernel.hpp"

namespace pusht {

/// Numbers of a cache line. The kernel's rows are whole lines.
constexpr int kLineValues = 16;

/// Replaces `count` values, whole lines, by kTanh, kErf, kExp, kExpMinusOne, kLog, kSigmoid, kSoftplus or kSqrt of
/// them. All instruction sets give the same bits. Results are within 0.501 ulp of the true value, also denormal ones;
/// kTanh has the bits of the C library's double tanh, rounded. A NaN stays NaN.
void applyFunction(Operation::Kind function, float* values, int count, InstructionSet instruction_set);

}  // namespace pusht
