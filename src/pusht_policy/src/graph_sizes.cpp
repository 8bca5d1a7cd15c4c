// SPDX-License-Identifier: BSD-3-Clause
#include "graph_sizes.hpp"

#include <algorithm>

namespace pusht {

using torch::jit::IValue;
using torch::jit::Node;
using torch::jit::Value;

bool GraphSizes::areComputedBy(const Node& node) {
  namespace prim = torch::jit::prim;
  namespace aten = torch::jit::aten;
  return node.kind() == prim::Constant || node.kind() == prim::ListConstruct || node.kind() == prim::NumToTensor ||
         node.kind() == aten::Int || node.kind() == aten::size || node.kind() == aten::__getitem__;
}

/// A size of a result, or all of them.
std::optional<IValue> GraphSizes::sizeOf(const Node& node) const {
  const auto shape = shapes_.find(node.input(0));
  if (shape == shapes_.end()) {
    return {};
  }
  if (node.inputs().size() == 1) {
    return shape->second;
  }
  const auto axis = valueOf(node.input(1));
  return axis ? std::optional<IValue>(torch::empty(shape->second).size(axis->toInt())) : std::nullopt;
}

std::optional<IValue> GraphSizes::valueOf(const Value* value) const {
  if (auto constant = torch::jit::toIValue(value)) {
    return constant;
  }
  const Node& node = *value->node();
  if (!areComputedBy(node) || node.inputs().empty()) {
    return {};
  }
  if (node.kind() == torch::jit::aten::size) {
    return sizeOf(node);
  }
  std::vector<IValue> inputs;
  for (const Value* input : node.inputs()) {
    const auto known = valueOf(input);
    if (!known) {
      return {};
    }
    inputs.push_back(*known);
  }
  if (node.kind() == torch::jit::prim::ListConstruct) {
    Sizes sizes(inputs.size());
    std::transform(inputs.begin(), inputs.end(), sizes.begin(), [](const IValue& size) { return size.toInt(); });
    return sizes;
  }
  if (node.kind() == torch::jit::aten::__getitem__) {
    return inputs.at(0).toIntVector().at(inputs.at(1).toInt());
  }
  return inputs.at(0);  // prim::NumToTensor and aten::Int, which tracing puts between
}

}  // namespace pusht
