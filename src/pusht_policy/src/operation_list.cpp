// SPDX-License-Identifier: BSD-3-Clause
#include "operation_list.hpp"

#include <functional>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

namespace pusht {
namespace {

std::int64_t countOf(const Sizes& shape) {
  return std::accumulate(shape.begin(), shape.end(), std::int64_t{1}, std::multiplies<>());
}

/// Size of the axis that is the `from_last`-th from the end; 1 before the first, as in the rule of extension.
std::int64_t sizeFromLast(const Sizes& shape, std::size_t from_last) {
  return from_last < shape.size() ? shape[shape.size() - 1 - from_last] : 1;
}

bool extends(const FloatTensor& operand, const Sizes& shape) {
  bool fits = operand.shape.size() <= shape.size();
  for (std::size_t axis = 0; fits && axis < operand.shape.size(); ++axis) {
    const std::int64_t size = sizeFromLast(operand.shape, axis);
    fits = size == 1 || size == sizeFromLast(shape, axis);
  }
  return fits;
}

/// Values of an operand for every element of `shape`, to which it extends: along an axis of size 1 they repeat.
std::vector<float> extended(const FloatTensor& operand, const Sizes& shape) {
  std::vector<float> values(countOf(shape));
  for (std::size_t i = 0; i < values.size(); ++i) {
    auto rest = static_cast<std::int64_t>(i);
    std::int64_t source = 0;
    std::int64_t stride = 1;
    for (std::size_t axis = 0; axis < shape.size(); ++axis) {
      const std::int64_t size = sizeFromLast(operand.shape, axis);
      source += stride * (rest % sizeFromLast(shape, axis) % size);
      stride *= size;
      rest /= sizeFromLast(shape, axis);
    }
    values[i] = operand.values[source];
  }
  return values;
}

}  // namespace

FloatTensor transposed(const FloatTensor& matrix) {
  if (matrix.shape.size() != 2) {
    throw UnfitOperand("its matrix must have two dimensions, not " + std::to_string(matrix.shape.size()));
  }
  const std::int64_t rows = matrix.shape[0];
  const std::int64_t columns = matrix.shape[1];
  FloatTensor result{{columns, rows}, std::vector<float>(matrix.values.size())};
  for (std::int64_t row = 0; row < rows; ++row) {
    for (std::int64_t column = 0; column < columns; ++column) {
      result.values[column * rows + row] = matrix.values[row * columns + column];
    }
  }
  return result;
}

int OperationList::columns() const { return static_cast<int>(countOf(shape_)); }

void OperationList::push(Operation::Kind kind, std::vector<float> operand) {
  numbers_ += operand.size();
  operations_.push_back({kind, columns(), std::move(operand)});
}

void OperationList::reshape(Sizes shape) {
  if (countOf(shape) != columns()) {
    throw UnfitOperand("must keep the " + std::to_string(columns()) + " columns");
  }
  shape_ = std::move(shape);
}

void OperationList::append(Operation::Kind kind, const FloatTensor& operand) {
  const FloatTensor& one = operand.values.size() == 1 ? scalar(operand.values.front()) : operand;
  if (!extends(one, shape_) || operand.shape.size() > shape_.size()) {
    throw UnfitOperand("its operand must have one value or one for each of " + std::to_string(columns()) + " columns");
  }
  push(kind, extended(one, shape_));
}

void OperationList::appendMatrix(const FloatTensor& matrix) {
  if (matrix.shape.size() != 2 || matrix.shape[0] != columns() || shape_.empty() || shape_.back() != columns() ||
      matrix.shape[1] < 1 || matrix.shape[1] > std::numeric_limits<int>::max()) {
    throw UnfitOperand("its matrix must be float32 for " + std::to_string(columns()) + " inputs");
  }
  shape_.back() = matrix.shape[1];
  push(Operation::Kind::kMatrix, matrix.values);
}

void OperationList::appendSubtractionFrom(const FloatTensor& minuend) {
  appendNegation();
  append(Operation::Kind::kAdd, minuend);
}

}  // namespace pusht
