// SPDX-License-Identifier: BSD-3-Clause
#include "kernel_product.hpp"

namespace pusht {
namespace {

// The product is vectorized over the columns, so that every sum runs in index order whatever the width of
// the vectors. `-ffp-contract=off` keeps multiplication and addition apart. All of it is inlined into one
// function per instruction set, below.

/// kRows x kVectors sums, held in registers.
template <class Vector, int kRows, int kVectors>
[[gnu::always_inline]] inline void multiplyTile(const Product& product, int row, int column) {
  const float* inputs = product.inputs + row * product.input_stride;
  const float* matrix = product.matrix + column;
  float* outputs = product.outputs + row * product.output_stride + column;
  Vector sums[kRows][kVectors] = {};  // NOLINT(modernize-avoid-c-arrays): std::array loses the attributes of Vector
  for (int k = 0; k < product.depth; ++k, matrix += product.columns) {
    const auto* weights = reinterpret_cast<const Vector*>(matrix);
#pragma GCC unroll 8
    for (int r = 0; r < kRows; ++r) {
      const float input = inputs[r * product.input_stride + k];
#pragma GCC unroll 8
      for (int v = 0; v < kVectors; ++v) {
        sums[r][v] += input * weights[v];
      }
    }
  }
#pragma GCC unroll 8
  for (int r = 0; r < kRows; ++r) {
#pragma GCC unroll 8
    for (int v = 0; v < kVectors; ++v) {
      reinterpret_cast<Vector*>(outputs + r * product.output_stride)[v] = sums[r][v];
    }
  }
}

/// The rows from `first_row` on, kRows at a time, and what is left of them fewer at a time.
template <class Vector, int kRows>
[[gnu::always_inline]] inline void multiplyRows(const Product& product, int first_row) {
  constexpr int kLanes = sizeof(Vector) / sizeof(float);
  constexpr int kVectors = kRows == 1 ? 8 : 4;  // a single row needs more sums to hide the latency of an addition
  const int end_row = product.rows - (product.rows - first_row) % kRows;
  int column = 0;
  for (; column + kVectors * kLanes <= product.columns; column += kVectors * kLanes) {
    for (int row = first_row; row < end_row; row += kRows) {
      multiplyTile<Vector, kRows, kVectors>(product, row, column);
    }
  }
  for (; column < product.columns; column += kLanes) {
    for (int row = first_row; row < end_row; row += kRows) {
      multiplyTile<Vector, kRows, 1>(product, row, column);
    }
  }
  if constexpr (kRows > 1) {
    multiplyRows<Vector, kRows - 1>(product, end_row);
  }
}

// Products by instruction set. Each takes as many rows at a time as there are registers for sums.
using Vector4 = float __attribute__((vector_size(16), may_alias));
void multiplyBaseline(const Product& product) { multiplyRows<Vector4, 3>(product, 0); }

#if defined(__x86_64__)
using Vector8 = float __attribute__((vector_size(32), may_alias));
[[gnu::target("avx2")]] void multiplyAvx2(const Product& product) { multiplyRows<Vector8, 3>(product, 0); }

using Vector16 = float __attribute__((vector_size(64), may_alias));
[[gnu::target("avx512f")]] void multiplyAvx512(const Product& product) { multiplyRows<Vector16, 6>(product, 0); }
#endif

}  // namespace

void multiply(const Product& product, InstructionSet instruction_set) {
  switch (instruction_set) {
#if defined(__x86_64__)
    case InstructionSet::kAvx512:
      return multiplyAvx512(product);
    case InstructionSet::kAvx2:
      return multiplyAvx2(product);
#endif
    default:
      return multiplyBaseline(product);
  }
}

}  // namespace pusht
