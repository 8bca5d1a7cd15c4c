// SPDX-License-Identifier: BSD-3-Clause
/// Network under construction: what the readers of its formats make of operations on tensors.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "pusht_policy/network_kernel.hpp"

namespace pusht {

/// Error: the kernel cannot run the network, for this reason.
struct UnfitForKernel : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Error: an operation cannot take its operands. The reader knows where it is in the file, and says it.
struct UnfitOperand : UnfitForKernel {
  using UnfitForKernel::UnfitForKernel;
};

/// Sizes of a tensor's dimensions.
using Sizes = std::vector<std::int64_t>;

/// Number of values of a shape without negative sizes. Throws UnfitOperand if that is more than a row may have.
int columnsOf(const Sizes& shape);

/// Axis of a tensor with so many; a negative one counts from the end. Throws UnfitOperand if there is none.
std::size_t axisOf(std::int64_t axis, std::size_t axes);

/// Constant of a network: a float32 tensor, row-major; a number has no dimension.
struct FloatTensor {
  Sizes shape;
  std::vector<float> values;
};

/// Tensor of one number.
inline FloatTensor scalar(float value) { return {{}, {value}}; }

/// Matrix with rows and columns exchanged. Throws UnfitOperand unless it has two dimensions.
FloatTensor transposed(const FloatTensor& matrix);

/// Float32 tensor for one rollout: a value of the kernel, or a constant.
struct NetworkTensor {
  Sizes shape;
  int value = -1;                                 ///< of the kernel, row-major; -1 for a constant
  std::shared_ptr<const FloatTensor> constant{};  ///< null for a value

  bool isConstant() const { return constant != nullptr; }
};

/// Elements of tensors side by side, in an order: what an operation takes that moves numbers and computes nothing.
struct Selection {
  Sizes shape;
  std::vector<int> elements;  ///< indices in the row-major elements of the sources, side by side
};

// Selections of one tensor, as its own elements in their order, and then of a selection.
Selection allOf(const Sizes& shape);
/// Every `step`-th index of an axis from `first` on, `count` of them.
Selection sliced(const Selection& of, std::size_t axis, std::int64_t first, std::int64_t step, std::int64_t count);
/// Axes in another order: axis i is the one that was order[i].
Selection permuted(const Selection& of, const std::vector<std::size_t>& order);
/// By the rule of numpy and torch. Throws UnfitOperand unless it extends to the shape.
Selection extended(const Selection& of, const Sizes& shape);

/// Network that grows by operations on tensors. Operations on constants alone give constants, with the kernel's bits.
/// Throws UnfitOperand where shapes do not fit.
class NetworkBuilder {
 public:
  /// Inputs of one rollout; the kernel's row has them side by side.
  explicit NetworkBuilder(const std::vector<Sizes>& inputs);

  NetworkTensor input(std::size_t index) { return inputs_.at(index); }
  static NetworkTensor constant(FloatTensor tensor);
  static NetworkTensor number(float value) { return constant(scalar(value)); }

  /// kAdd to kMin, element by element; shapes extend by the rule of numpy and torch.
  NetworkTensor combine(Operation::Kind kind, const NetworkTensor& left, const NetworkTensor& right);
  NetworkTensor combine(Operation::Kind kind, const NetworkTensor& left, float right) {
    return combine(kind, left, number(right));
  }
  /// kTanh to kSqrt, of each element.
  NetworkTensor apply(Operation::Kind function, const NetworkTensor& tensor);
  /// Product along the last axis with a constant matrix [inputs, columns].
  NetworkTensor multiplyMatrix(const NetworkTensor& rows, const FloatTensor& matrix);
  /// Sums along axes, which stay with size 1.
  NetworkTensor sum(const NetworkTensor& tensor, const std::vector<std::int64_t>& axes);
  NetworkTensor select(const std::vector<NetworkTensor>& sources, const Selection& selection);
  /// Tensors one behind the other along an axis.
  NetworkTensor concatenate(const std::vector<NetworkTensor>& tensors, std::int64_t axis);
  /// Takes the elements as another shape; no number moves.
  NetworkTensor reshape(NetworkTensor tensor, Sizes shape);

  /// Operations that the outputs need; the last one has them side by side.
  std::vector<Operation> finish(const std::vector<NetworkTensor>& outputs);

  /// Numbers of all operands and constants so far.
  std::size_t numbers() const { return numbers_; }

 private:
  NetworkTensor push(Operation operation, Sizes shape);
  NetworkTensor fold(Operation operation, const std::vector<NetworkTensor>& sources, Sizes shape);
  NetworkTensor take(Operation::Kind kind, const std::vector<NetworkTensor>& sources, const Sizes& shape);
  NetworkTensor combineWithConstant(Operation::Kind kind, const NetworkTensor& left, const NetworkTensor& right,
                                    const Sizes& shape);
  NetworkTensor extend(const NetworkTensor& tensor, const Sizes& shape);
  NetworkTensor computed(const NetworkTensor& tensor);

  int input_columns_ = 0;
  std::vector<NetworkTensor> inputs_;
  std::vector<Operation> operations_;
  std::size_t numbers_ = 0;
};

}  // namespace pusht
