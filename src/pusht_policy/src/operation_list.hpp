// SPDX-License-Identifier: BSD-3-Clause
/// Operations of a network as the readers of its formats find them, one after the other, each checked when it comes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <utility>
#include <vector>

#include "pusht_policy/network_kernel.hpp"

namespace pusht {

/// Error: the kernel cannot run the network, for this reason.
struct UnfitForKernel : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Error: what a list of operations is to append does not fit. The reader knows where it is in the file, and says it.
struct UnfitOperand : UnfitForKernel {
  using UnfitForKernel::UnfitForKernel;
};

/// Sizes of a tensor's dimensions.
using Sizes = std::vector<std::int64_t>;

/// Constant of a network: a float32 tensor, row-major; a number has no dimension.
struct FloatTensor {
  Sizes shape;
  std::vector<float> values;
};

/// Tensor of one number.
inline FloatTensor scalar(float value) { return {{}, {value}}; }

/// Matrix with rows and columns exchanged. Throws UnfitOperand unless it has two dimensions.
FloatTensor transposed(const FloatTensor& matrix);

/// Sequence of operations on a row of the kernel. The network sees the row as a tensor of one rollout, [1, columns] at
/// the beginning, to whose shape operands extend.
class OperationList {
 public:
  explicit OperationList(Sizes shape) : shape_(std::move(shape)) {}

  /// Shape of the tensor after the last operation.
  const Sizes& shape() const { return shape_; }

  /// Columns of the row after the last operation.
  int columns() const;

  /// Takes the row as another shape; no number moves. Throws UnfitOperand unless it has as many numbers.
  void reshape(Sizes shape);

  /// Appends an element-wise operation. Throws UnfitOperand unless the operand extends to the shape of the row, by
  /// the rule of numpy and torch.
  void append(Operation::Kind kind, const FloatTensor& operand);

  /// Appends the product with a matrix [inputs, columns]. Throws UnfitOperand unless the row has as many inputs.
  void appendMatrix(const FloatTensor& matrix);

  void appendTanh() { push(Operation::Kind::kTanh, {}); }
  void appendNegation() { append(Operation::Kind::kMultiply, scalar(-1.0F)); }

  /// Appends `minuend` minus the row: -x + c is c - x to the last bit. Throws UnfitOperand as append().
  void appendSubtractionFrom(const FloatTensor& minuend);

  const std::vector<Operation>& operations() const { return operations_; }

  /// Numbers of all operands.
  std::size_t numbers() const { return numbers_; }

 private:
  void push(Operation::Kind kind, std::vector<float> operand);

  Sizes shape_;
  std::size_t numbers_ = 0;
  std::vector<Operation> operations_;
};

}  // namespace pusht
