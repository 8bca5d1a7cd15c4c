// SPDX-License-Identifier: BSD-3-Clause
#include "network_builder.hpp"

#include <algorithm>
#include <functional>
#include <numeric>
#include <string>
#include <utility>

namespace pusht {
namespace {

using Kind = Operation::Kind;

/// Size of the axis that is the `from_last`-th from the end; 1 before the first, as in the rule of extension.
std::int64_t sizeFromLast(const Sizes& shape, std::size_t from_last) {
  return from_last < shape.size() ? shape[shape.size() - 1 - from_last] : 1;
}

/// Shape to which both extend. Throws UnfitOperand if there is none.
Sizes commonShape(const Sizes& left, const Sizes& right) {
  Sizes shape(std::max(left.size(), right.size()));
  for (std::size_t axis = 0; axis < shape.size(); ++axis) {
    const std::int64_t a = sizeFromLast(left, axis);
    const std::int64_t b = sizeFromLast(right, axis);
    if (a != b && a != 1 && b != 1) {
      throw UnfitOperand("its operand must have one value or one for each of " + std::to_string(columnsOf(left)) +
                         " columns");
    }
    shape[shape.size() - 1 - axis] = a == 1 ? b : a;
  }
  return shape;
}

/// Throws UnfitOperand if a constant makes several rollouts of one.
void requireOneRollout(const NetworkTensor& rows, const Sizes& shape) {
  const bool has_more = shape.size() >= rows.shape.size() && !shape.empty() && shape.front() != 1 &&
                        (shape.size() > rows.shape.size() || rows.shape.front() == 1);
  if (has_more) {
    throw UnfitOperand("its operand must have one value or one for each of " + std::to_string(columnsOf(rows.shape)) +
                       " columns");
  }
}

bool isWhole(const Selection& selection) {
  for (std::size_t i = 0; i < selection.elements.size(); ++i) {
    if (selection.elements[i] != static_cast<int>(i)) {
      return false;
    }
  }
  return true;
}

/// Elements of `of` that a shape's elements are, where each step along an axis is so many elements.
Selection strided(const Selection& of, Sizes shape, const std::vector<std::int64_t>& strides, std::int64_t first) {
  Selection result{std::move(shape), {}};
  result.elements.resize(columnsOf(result.shape));
  for (std::size_t i = 0; i < result.elements.size(); ++i) {
    auto rest = static_cast<std::int64_t>(i);
    std::int64_t source = first;
    for (std::size_t axis = result.shape.size(); axis-- > 0; rest /= result.shape[axis]) {
      source += strides[axis] * (rest % result.shape[axis]);
    }
    result.elements[i] = of.elements[source];
  }
  return result;
}

void requireNotEmpty(const Sizes& shape) {
  if (columnsOf(shape) == 0) {
    throw UnfitOperand("its operands and its result must not be empty");
  }
}

std::vector<std::int64_t> stridesOf(const Sizes& shape) {
  std::vector<std::int64_t> strides(shape.size(), 1);
  for (std::size_t axis = shape.size(); axis-- > 1;) {
    strides[axis - 1] = strides[axis] * shape[axis];
  }
  return strides;
}

}  // namespace

int columnsOf(const Sizes& shape) {
  constexpr std::int64_t kMost = std::int64_t{1} << 24U;
  std::int64_t count = 1;
  for (const std::int64_t size : shape) {
    if (size < 0 || size > kMost || (count *= size) > kMost) {
      throw UnfitOperand("a tensor must have at most " + std::to_string(kMost) + " numbers for one rollout");
    }
  }
  return static_cast<int>(count);
}

std::size_t axisOf(std::int64_t axis, std::size_t axes) {
  const auto count = static_cast<std::int64_t>(axes);
  if (axis < -count || axis >= count) {
    throw UnfitOperand("its axis must be one of " + std::to_string(count) + ", not " + std::to_string(axis));
  }
  return static_cast<std::size_t>(axis < 0 ? axis + count : axis);
}

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

Selection allOf(const Sizes& shape) {
  Selection all{shape, std::vector<int>(columnsOf(shape))};
  std::iota(all.elements.begin(), all.elements.end(), 0);
  return all;
}

Selection sliced(const Selection& of, std::size_t axis, std::int64_t first, std::int64_t step, std::int64_t count) {
  Sizes shape = of.shape;
  std::vector<std::int64_t> strides = stridesOf(shape);
  const std::int64_t begin = first * strides[axis];
  shape[axis] = count;
  strides[axis] *= step;
  return strided(of, std::move(shape), strides, begin);
}

Selection permuted(const Selection& of, const std::vector<std::size_t>& order) {
  const std::vector<std::int64_t> strides = stridesOf(of.shape);
  Sizes shape;
  std::vector<std::int64_t> permuted_strides;
  for (const std::size_t axis : order) {
    shape.push_back(of.shape.at(axis));
    permuted_strides.push_back(strides.at(axis));
  }
  return strided(of, std::move(shape), permuted_strides, 0);
}

Selection extended(const Selection& of, const Sizes& shape) {
  if (of.shape.size() > shape.size() || commonShape(of.shape, shape) != shape) {
    throw UnfitOperand("must extend to the shape that it is given");
  }
  const std::vector<std::int64_t> old = stridesOf(of.shape);
  std::vector<std::int64_t> strides(shape.size(), 0);
  for (std::size_t axis = 0; axis < of.shape.size(); ++axis) {
    strides[shape.size() - 1 - axis] = sizeFromLast(of.shape, axis) == 1 ? 0 : old[old.size() - 1 - axis];
  }
  return strided(of, shape, strides, 0);
}

NetworkBuilder::NetworkBuilder(const std::vector<Sizes>& inputs) {
  std::vector<int> first;
  for (const Sizes& shape : inputs) {
    first.push_back(input_columns_);
    input_columns_ += columnsOf(shape);
  }
  const NetworkTensor whole{{input_columns_}, 0};
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    Selection part = allOf(inputs[i]);
    for (int& element : part.elements) {
      element += first[i];
    }
    inputs_.push_back(inputs.size() == 1 ? NetworkTensor{inputs[i], 0} : select({whole}, part));
  }
}

NetworkTensor NetworkBuilder::constant(FloatTensor tensor) {
  const Sizes shape = tensor.shape;
  return {shape, -1, std::make_shared<const FloatTensor>(std::move(tensor))};
}

NetworkTensor NetworkBuilder::push(Operation operation, Sizes shape) {
  requireNotEmpty(shape);
  constexpr std::size_t kMostNumbers = std::size_t{1} << 28U;  // 1 GB
  numbers_ += operation.operand.size() + operation.picked.size();
  if (numbers_ > kMostNumbers) {
    throw UnfitOperand("the network must have at most " + std::to_string(kMostNumbers) + " numbers");
  }
  operations_.push_back(std::move(operation));
  return {std::move(shape), static_cast<int>(operations_.size())};
}

/// Result of an operation of constants, as the kernel has it.
NetworkTensor NetworkBuilder::fold(Operation operation, const std::vector<NetworkTensor>& sources, Sizes shape) {
  requireNotEmpty(shape);
  std::vector<Operation> operations;
  for (const NetworkTensor& source : sources) {
    requireNotEmpty(source.shape);
    operations.push_back({Kind::kConstant, columnsOf(source.shape), source.constant->values});
    operation.sources.push_back(static_cast<int>(operations.size()));
  }
  std::vector<float> values(operation.columns);
  operations.push_back(std::move(operation));
  const float nothing = 0.0F;
  NetworkKernel(1, operations).run({&nothing, 1}, values);
  numbers_ += values.size();
  return constant({std::move(shape), std::move(values)});
}

/// Result of an operation of tensors that all are constants, or all values.
NetworkTensor NetworkBuilder::take(Kind kind, const std::vector<NetworkTensor>& sources, const Sizes& shape) {
  Operation operation{kind, columnsOf(shape)};
  if (sources.front().isConstant()) {
    return fold(std::move(operation), sources, shape);
  }
  for (const NetworkTensor& source : sources) {
    operation.sources.push_back(source.value);
  }
  return push(std::move(operation), shape);
}

/// The tensor as a value, also if it is a constant.
NetworkTensor NetworkBuilder::computed(const NetworkTensor& tensor) {
  return tensor.isConstant() ? push({Kind::kConstant, columnsOf(tensor.shape), tensor.constant->values}, tensor.shape)
                             : tensor;
}

NetworkTensor NetworkBuilder::extend(const NetworkTensor& tensor, const Sizes& shape) {
  return tensor.shape == shape ? tensor : select({tensor}, extended(allOf(tensor.shape), shape));
}

NetworkTensor NetworkBuilder::combine(Kind kind, const NetworkTensor& left, const NetworkTensor& right) {
  // One number with more dimensions extends to every shape.
  if (left.isConstant() != right.isConstant()) {
    const NetworkTensor& operand = left.isConstant() ? left : right;
    if (operand.constant->values.size() == 1 && !operand.shape.empty()) {
      const NetworkTensor one = number(operand.constant->values.front());
      return left.isConstant() ? combine(kind, one, right) : combine(kind, left, one);
    }
  }
  const NetworkTensor& rows = left.isConstant() ? right : left;
  const NetworkTensor& other = left.isConstant() ? left : right;
  const Sizes shape = commonShape(rows.shape, other.shape);
  if (left.isConstant() != right.isConstant()) {
    requireOneRollout(rows, shape);
    return combineWithConstant(kind, left, right, shape);
  }
  return take(kind, {extend(left, shape), extend(right, shape)}, shape);
}

NetworkTensor NetworkBuilder::combineWithConstant(Kind kind, const NetworkTensor& left, const NetworkTensor& right,
                                                  const Sizes& shape) {
  if (left.isConstant() && kind == Kind::kDivide) {
    return take(kind, {computed(extend(left, shape)), extend(right, shape)}, shape);
  }
  if (left.isConstant() && kind == Kind::kSubtract) {  // c - x is -x + c to the last bit
    return combine(Kind::kAdd, combine(Kind::kMultiply, right, -1.0F), left);
  }
  const NetworkTensor rows = extend(left.isConstant() ? right : left, shape);
  const NetworkTensor operand = extend(left.isConstant() ? left : right, shape);
  return push({kind, columnsOf(shape), operand.constant->values, {rows.value}}, shape);
}

NetworkTensor NetworkBuilder::apply(Kind function, const NetworkTensor& tensor) {
  return take(function, {tensor}, tensor.shape);
}

NetworkTensor NetworkBuilder::multiplyMatrix(const NetworkTensor& rows, const FloatTensor& matrix) {
  if (matrix.shape.size() != 2 || rows.shape.empty() || matrix.shape[0] != rows.shape.back() || matrix.shape[0] < 1 ||
      matrix.shape[1] < 1) {
    throw UnfitOperand("its matrix must be float32 for " + std::to_string(rows.shape.empty() ? 1 : rows.shape.back()) +
                       " inputs");
  }
  const int columns = columnsOf({matrix.shape[1]});
  const int parts = columnsOf(rows.shape) / columnsOf({matrix.shape[0]});
  Sizes shape = rows.shape;
  shape.back() = columns;
  std::vector<NetworkTensor> products;
  const Sizes parted = {parts, matrix.shape[0]};
  for (int part = 0; part < parts; ++part) {
    const NetworkTensor row =
        select({computed(rows)}, parts == 1 ? allOf(parted) : sliced(allOf(parted), 0, part, 1, 1));
    products.push_back(push({Kind::kMatrix, columns, matrix.values, {row.value}}, {1, columns}));
  }
  return reshape(concatenate(products, 0), shape);
}

NetworkTensor NetworkBuilder::sum(const NetworkTensor& tensor, const std::vector<std::int64_t>& axes) {
  Sizes shape = tensor.shape;
  std::vector<std::size_t> last;
  for (const std::int64_t axis : axes) {
    last.push_back(axisOf(axis, shape.size()));
    shape[last.back()] = 1;
  }
  std::vector<std::size_t> order;
  for (std::size_t axis = 0; axis < shape.size(); ++axis) {
    if (std::find(last.begin(), last.end(), axis) == last.end()) {
      order.push_back(axis);
    }
  }
  std::sort(last.begin(), last.end());
  order.insert(order.end(), last.begin(), last.end());
  return take(Kind::kSum, {select({tensor}, permuted(allOf(tensor.shape), order))}, shape);
}

NetworkTensor NetworkBuilder::select(const std::vector<NetworkTensor>& sources, const Selection& selection) {
  requireNotEmpty(selection.shape);
  if (sources.size() == 1 && isWhole(selection) &&
      columnsOf(sources[0].shape) == static_cast<int>(selection.elements.size())) {
    return reshape(sources[0], selection.shape);
  }
  Operation operation{Kind::kPick, static_cast<int>(selection.elements.size()), {}, {}, selection.elements};
  if (std::all_of(sources.begin(), sources.end(), [](const NetworkTensor& source) { return source.isConstant(); })) {
    return fold(std::move(operation), sources, selection.shape);
  }
  for (const NetworkTensor& source : sources) {
    operation.sources.push_back(computed(source).value);
  }
  return push(std::move(operation), selection.shape);
}

NetworkTensor NetworkBuilder::concatenate(const std::vector<NetworkTensor>& tensors, std::int64_t axis) {
  if (tensors.empty()) {
    throw UnfitOperand("must have operands");
  }
  Sizes shape = tensors.front().shape;
  const std::size_t along = axisOf(axis, shape.size());
  std::vector<int> first;  // element of each tensor among all
  int count = 0;
  shape[along] = 0;
  for (const NetworkTensor& tensor : tensors) {
    Sizes expected = shape;
    if (tensor.shape.size() == shape.size()) {
      expected[along] = tensor.shape[along];
    }
    if (tensor.shape != expected) {
      throw UnfitOperand("its operands must have the same shape but along the axis");
    }
    shape[along] += tensor.shape[along];
    first.push_back(count);
    count += columnsOf(tensor.shape);
  }
  const auto outer = columnsOf({shape.begin(), shape.begin() + static_cast<std::ptrdiff_t>(along)});
  Selection selection{shape, {}};
  for (int i = 0; i < outer; ++i) {
    for (std::size_t t = 0; t < tensors.size(); ++t) {
      const int inner = columnsOf(tensors[t].shape) / std::max(outer, 1);
      for (int j = 0; j < inner; ++j) {
        selection.elements.push_back(first[t] + i * inner + j);
      }
    }
  }
  return select(tensors, selection);
}

NetworkTensor NetworkBuilder::reshape(NetworkTensor tensor, Sizes shape) {
  if (columnsOf(shape) != columnsOf(tensor.shape)) {
    throw UnfitOperand("must keep the " + std::to_string(columnsOf(tensor.shape)) + " columns");
  }
  if (tensor.isConstant()) {
    return constant({std::move(shape), tensor.constant->values});
  }
  tensor.shape = std::move(shape);
  return tensor;
}

std::vector<Operation> NetworkBuilder::finish(const std::vector<NetworkTensor>& outputs) {
  std::vector<NetworkTensor> rows;
  rows.reserve(outputs.size());
  for (const NetworkTensor& output : outputs) {
    rows.push_back(reshape(computed(output), {columnsOf(output.shape)}));
  }
  const int result = concatenate(rows, 0).value;
  std::vector<bool> needed(operations_.size() + 1);
  needed[result] = true;
  std::vector<int> renumbered(operations_.size() + 1);
  for (int value = result; value > 0; --value) {
    for (const int source : operations_[value - 1].sources) {
      needed[source] = needed[source] || needed[value];
    }
  }
  std::vector<Operation> operations;
  for (int value = 1; value <= result; ++value) {
    if (needed[value]) {
      operations.push_back(operations_[value - 1]);
      for (int& source : operations.back().sources) {
        source = renumbered[source];
      }
      renumbered[value] = static_cast<int>(operations.size());
    }
  }
  return operations;
}

}  // namespace pusht
