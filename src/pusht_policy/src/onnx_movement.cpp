// SPDX-License-Identifier: BSD-3-Clause
// Operators of ONNX that move numbers, and constants of shapes.
#include <onnx/onnx_pb.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "onnx_reader.hpp"

namespace pusht {

using onnx::TensorProto;

OnnxReader::Values OnnxReader::readConstant(const Node& node) {
  OnnxConstant constant = readConstantNode(node, files_);
  other_numbers_ += constant.numbers.size() + constant.tensor.values.size();
  return {number(std::move(constant))};
}

OnnxReader::Values OnnxReader::readConstantOfShape(const Node& node) {
  OnnxConstant constant{TensorProto::FLOAT, {integers(node, 0), {}}, {}};
  const int count = columnsOf(constant.tensor.shape);
  const OnnxConstant element = hasAttribute(node, "value") ? readTensor(node.attribute(0).t(), "value", files_)
                                                           : OnnxConstant{TensorProto::FLOAT, {{1}, {0.0F}}, {}};
  constant.type = element.type;
  if (element.tensor.values.size() + element.numbers.size() != 1) {
    throw UnfitForKernel("its value must be one number");
  }
  if (element.type == TensorProto::FLOAT) {
    constant.tensor.values.assign(count, element.tensor.values.front());
  } else {
    constant.numbers.assign(count, element.numbers.front());
  }
  other_numbers_ += count;
  return {number(std::move(constant))};
}

/// For one rollout: the number of rows is 1.
OnnxReader::Values OnnxReader::readShape(const Node& node) {
  const Sizes& shape = value(node, 0).shape();
  const auto bound = [&](const char* name, std::int64_t otherwise) {
    const auto size = static_cast<std::int64_t>(shape.size());
    const std::int64_t axis = integerOf(node, name, otherwise);
    return std::clamp<std::int64_t>(axis < 0 ? axis + size : axis, 0, size);
  };
  const std::int64_t first = bound("start", 0);
  const std::int64_t end = std::max(first, bound("end", static_cast<std::int64_t>(shape.size())));
  OnnxConstant constant{TensorProto::INT64, {{end - first}, {}}, {}};
  constant.numbers.assign(shape.begin() + first, shape.begin() + end);
  return {number(std::move(constant))};
}

OnnxReader::Values OnnxReader::readCast(const Node& node) {
  const Value& source = value(node, 0);
  const std::int64_t type = integerOf(node, "to", 0);
  if (type == TensorProto::FLOAT) {
    return {source.other == nullptr ? source : number(castToFloat(*source.other))};
  }
  if (source.other == nullptr || (type != TensorProto::INT64 && type != TensorProto::INT32)) {
    throw UnfitForKernel("must keep float32");
  }
  OnnxConstant integers = *source.other;
  integers.type = static_cast<int>(type);
  for (double& number : integers.numbers) {
    number = std::trunc(number);
  }
  return {number(std::move(integers))};
}

/// In inference it changes nothing; since opset 12 an input says whether it is in training.
OnnxReader::Values OnnxReader::readDropout(const Node& node) {
  constexpr int kTrains = 2;
  if (has(node, kTrains) && numbers(node, kTrains) != std::vector<double>{0.0}) {
    throw UnfitForKernel("must be off: call .eval() before exporting");
  }
  return {value(node, 0)};
}

OnnxReader::Values OnnxReader::readFlatten(const Node& node) {
  const Sizes& shape = value(node, 0).shape();
  const std::int64_t axis = integerOf(node, "axis", 1);
  const std::size_t end = axis == static_cast<std::int64_t>(shape.size()) ? shape.size() : axisOf(axis, shape.size());
  if (end == 0) {
    throw UnfitForKernel("must keep the rollouts apart: its axis must not be 0");
  }
  const int outer = columnsOf({shape.begin(), shape.begin() + static_cast<std::ptrdiff_t>(end)});
  const int inner = columnsOf({shape.begin() + static_cast<std::ptrdiff_t>(end), shape.end()});
  return {reshaped(value(node, 0), {outer, inner})};
}

/// A number of rows that is written as 1 means the single row that the network was exported for.
OnnxReader::Values OnnxReader::readReshape(const Node& node) {
  const Sizes& old = value(node, 0).shape();
  Sizes shape = integers(node, 1);
  const bool zero_keeps = integerOf(node, "allowzero", 0) == 0;
  std::int64_t known = 1;
  std::int64_t* open = nullptr;
  for (std::size_t axis = 0; axis < shape.size(); ++axis) {
    if (shape[axis] == 0 && zero_keeps && axis < old.size()) {
      shape[axis] = old[axis];
    }
    if (shape[axis] == -1 && open == nullptr) {
      open = &shape[axis];
    } else {
      known = columnsOf({known, shape[axis]});
    }
  }
  if (open != nullptr) {
    *open = columnsOf(old) / std::max<std::int64_t>(known, 1);
  }
  if (columnsOf(shape) != columnsOf(old)) {
    throw UnfitForKernel("must keep the " + std::to_string(columnsOf(old)) + " numbers of a row");
  }
  return {reshaped(value(node, 0), shape)};
}

OnnxReader::Values OnnxReader::readSqueeze(const Node& node) {
  constexpr std::int64_t kAxesAreInputsSince = 13;
  const Value& source = value(node, 0);
  const Sizes axes = axesOf(node, kAxesAreInputsSince, source);
  Sizes shape;
  for (std::size_t axis = 0; axis < source.shape().size(); ++axis) {
    const bool named = std::count(axes.begin(), axes.end(), static_cast<std::int64_t>(axis)) > 0;
    if (source.shape()[axis] != 1 || !(named || axes.empty())) {
      shape.push_back(source.shape()[axis]);
    }
  }
  return {reshaped(source, shape)};
}

OnnxReader::Values OnnxReader::readUnsqueeze(const Node& node) {
  const Value& source = value(node, 0);
  Sizes axes = has(node, 1) ? integers(node, 1) : integersOf(node, "axes");
  Sizes shape = source.shape();
  const std::size_t count = shape.size() + axes.size();
  for (std::int64_t& axis : axes) {
    axis = static_cast<std::int64_t>(axisOf(axis, count));
  }
  std::sort(axes.begin(), axes.end());
  for (const std::int64_t axis : axes) {
    shape.insert(shape.begin() + std::min<std::ptrdiff_t>(axis, static_cast<std::ptrdiff_t>(shape.size())), 1);
  }
  return {reshaped(source, shape)};
}

OnnxReader::Values OnnxReader::readTranspose(const Node& node) {
  const Value& source = value(node, 0);
  std::vector<std::size_t> order;
  for (const std::int64_t axis : integersOf(node, "perm")) {
    order.push_back(axisOf(axis, source.shape().size()));
  }
  if (order.empty()) {
    order.resize(source.shape().size());
    std::iota(order.rbegin(), order.rend(), 0);
  }
  if (order.size() != source.shape().size() || std::set(order.begin(), order.end()).size() != order.size()) {
    throw UnfitForKernel("its perm must name each dimension once");
  }
  return {select(source, permuted(allOf(source.shape()), order))};
}

OnnxReader::Values OnnxReader::readExpand(const Node& node) {
  const Value& source = value(node, 0);
  Sizes shape = integers(node, 1);
  while (shape.size() < source.shape().size()) {
    shape.insert(shape.begin(), 1);
  }
  for (std::size_t i = 0; i < source.shape().size(); ++i) {  // by the rule of extension, in both directions
    std::int64_t& size = shape[shape.size() - 1 - i];
    const std::int64_t old = source.shape()[source.shape().size() - 1 - i];
    size = size == 1 ? old : size;
  }
  return {select(source, extended(allOf(source.shape()), shape))};
}

OnnxReader::Values OnnxReader::readConcat(const Node& node) {
  const std::int64_t axis = integerOf(node, "axis", 0);
  if (value(node, 0).other == nullptr) {
    std::vector<NetworkTensor> tensors;
    tensors.reserve(static_cast<std::size_t>(node.input_size()));
    for (int i = 0; i < node.input_size(); ++i) {
      tensors.push_back(tensor(node, i));
    }
    return one(network_.concatenate(tensors, axis));
  }
  OnnxConstant whole = *value(node, 0).other;
  for (int i = 1; i < node.input_size(); ++i) {
    const std::vector<double>& more = numbers(node, i);
    whole.numbers.insert(whole.numbers.end(), more.begin(), more.end());
  }
  whole.tensor.shape = {static_cast<std::int64_t>(whole.numbers.size())};
  other_numbers_ += whole.numbers.size();
  return {number(std::move(whole))};
}

/// Sizes are an attribute before opset 13, an input from then on, and left out for equal parts.
OnnxReader::Values OnnxReader::readSplit(const Node& node) {
  const Value& source = value(node, 0);
  const std::size_t axis = axisOf(integerOf(node, "axis", 0), source.shape().size());
  Sizes sizes = has(node, 1) ? integers(node, 1) : integersOf(node, "split");
  if (sizes.empty()) {
    const std::int64_t parts = node.output_size();
    const std::int64_t size = (source.shape()[axis] + parts - 1) / parts;
    sizes.assign(parts, size);
    sizes.back() = source.shape()[axis] - size * (parts - 1);
  }
  if (source.other != nullptr || static_cast<int>(sizes.size()) != node.output_size()) {
    throw UnfitForKernel("must have a size of a float32 part for each output");
  }
  Values results;
  for (NetworkTensor& part : layers_.split(source.tensor, axis, sizes)) {
    results.push_back({std::move(part)});
  }
  return results;
}

/// Bounds are attributes before opset 10, inputs from then on.
OnnxReader::Values OnnxReader::readSlice(const Node& node) {
  constexpr int kEnds = 2;
  constexpr int kAxes = 3;
  constexpr int kSteps = 4;
  const Value& source = value(node, 0);
  const auto list = [&](int input, const char* name) {
    return has(node, input) ? integers(node, input) : integersOf(node, name);
  };
  const Sizes starts = list(1, "starts");
  const Sizes ends = list(kEnds, "ends");
  Sizes axes = list(kAxes, "axes");
  Sizes steps = has(node, kSteps) ? integers(node, kSteps) : Sizes(starts.size(), 1);
  if (axes.empty()) {
    axes.resize(starts.size());
    std::iota(axes.begin(), axes.end(), 0);
  }
  if (ends.size() != starts.size() || axes.size() != starts.size() || steps.size() != starts.size() || starts.empty()) {
    throw UnfitForKernel("must have a start, an end, an axis and a step for each slice");
  }
  Selection selection = allOf(source.shape());
  for (std::size_t i = 0; i < starts.size(); ++i) {
    const std::size_t axis = axisOf(axes[i], source.shape().size());
    const std::int64_t size = selection.shape[axis];
    const auto bound = [&](std::int64_t index) {
      return std::clamp<std::int64_t>(index < 0 ? index + size : index, 0, size);
    };
    if (steps[i] < 1) {
      throw UnfitForKernel("its steps must be at least 1");
    }
    const std::int64_t first = bound(starts[i]);
    const std::int64_t count = std::max<std::int64_t>(0, (bound(ends[i]) - first + steps[i] - 1) / steps[i]);
    selection = sliced(selection, axis, first, steps[i], count);
  }
  return {select(source, selection)};
}

/// Indices are constants with at most one dimension.
OnnxReader::Values OnnxReader::readGather(const Node& node) {
  const Value& source = value(node, 0);
  const std::size_t axis = axisOf(integerOf(node, "axis", 0), source.shape().size());
  const Sizes& shape_of_indices = value(node, 1).shape();
  const Sizes indices = integers(node, 1);
  const std::int64_t size = source.shape()[axis];
  Selection all = allOf(source.shape());
  Selection result{source.shape(), {}};
  result.shape[axis] = static_cast<std::int64_t>(indices.size());
  if (shape_of_indices.size() > 1) {
    throw UnfitForKernel("its indices must have at most one dimension");
  }
  const int outer = columnsOf({all.shape.begin(), all.shape.begin() + static_cast<std::ptrdiff_t>(axis)});
  const int inner = columnsOf(all.shape) / std::max(columnsOf({outer, size}), 1);
  columnsOf(result.shape);
  for (int i = 0; i < outer; ++i) {
    for (const std::int64_t index : indices) {
      if (index < -size || index >= size) {
        throw UnfitForKernel("its indices must be of one of " + std::to_string(size));
      }
      for (int j = 0; j < inner; ++j) {
        result.elements.push_back(static_cast<int>((i * size + (index < 0 ? index + size : index)) * inner) + j);
      }
    }
  }
  if (shape_of_indices.empty()) {
    result.shape.erase(result.shape.begin() + static_cast<std::ptrdiff_t>(axis));
  }
  return {select(source, result)};
}

}  // namespace pusht
