// SPDX-License-Identifier: BSD-3-Clause
/// Product of rows and a matrix, the kernel's inner loop.
#pragma once

#include "pusht_policy/network_kernel.hpp"

namespace pusht {

/// outputs[rows][columns] = inputs[rows][depth] * matrix[depth][columns]; columns are whole lines.
struct Product {
  const float* inputs;
  const float* matrix;
  float* outputs;
  int rows;
  int depth;
  int columns;
  int input_stride;
  int output_stride;
};

/// Computes the product; every sum runs in index order, from 0.
void multiply(const Product& product, InstructionSet instruction_set);

}  // namespace pusht
