// SPDX-License-Identifier: BSD-3-Clause
#include "graph_sizes.hpp"

#include <algorithm>

namespace pusht {

using torch::jit::IValue;
using torch::jit::Node;
using torch::jit::Value;

namespace {

/// Whether a type has tensors in it.
bool hasTensors(const c10::TypePtr& type) {
  const auto contained = type->containedTypes();
  return type->isSubtypeOf(*c10::TensorType::get()) ||
         std::any_of(contained.begin(), contained.end(), [](const c10::TypePtr& part) { return hasTensors(part); });
}

}  // namespace

bool GraphSizes::areComputedBy(const Node& node) {
  namespace prim = torch::jit::prim;
  const auto outputs = node.outputs();
  return node.kind() == prim::Constant || node.kind() == prim::NumToTensor ||
         (!outputs.empty() && node.blocks().empty() &&
          std::none_of(outputs.begin(), outputs.end(), [](const Value* output) { return hasTensors(output->type()); }));
}

/// Result of an operation, which libtorch computes. It may ask the shape of a tensor, but not its numbers.
std::optional<IValue> GraphSizes::computed(const Node& node) const {
  namespace aten = torch::jit::aten;
  const bool asks_shape = node.kind() == aten::size || node.kind() == aten::dim || node.kind() == aten::len ||
                          node.kind() == aten::__is__ || node.kind() == aten::__isnot__;
  torch::jit::Stack stack;
  for (const Value* input : node.inputs()) {
    const auto shape = shapes_.find(input);
    const bool is_tensor = shape != shapes_.end();
    const auto known = is_tensor ? std::optional<IValue>(torch::empty(shape->second)) : valueOf(input);
    if (!known || (is_tensor && !asks_shape)) {
      return {};
    }
    stack.push_back(*known);
  }
  if (node.kind() == torch::jit::prim::TupleConstruct) {
    return c10::ivalue::Tuple::create(std::move(stack));
  }
  if (node.kind() == torch::jit::prim::ListConstruct) {
    c10::impl::GenericList list(node.output()->type()->containedType(0));
    std::for_each(stack.begin(), stack.end(), [&](const IValue& element) { list.push_back(element); });
    return IValue(list);
  }
  if (node.maybeOperator() == nullptr) {
    return {};
  }
  node.getOperation()(stack);
  return stack.empty() ? std::nullopt : std::optional<IValue>(stack.front());
}

std::optional<IValue> GraphSizes::valueOf(const Value* value) const {
  if (auto constant = torch::jit::toIValue(value)) {
    return constant;
  }
  if (const auto same = same_.find(value); same != same_.end()) {
    return valueOf(same->second);
  }
  const Node& node = *value->node();
  if (!areComputedBy(node) || node.outputs().size() != 1 || node.kind() == torch::jit::prim::Param) {
    return {};
  }
  return computed(node);
}

}  // namespace pusht
