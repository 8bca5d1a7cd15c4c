// SPDX-License-Identifier: BSD-3-Clause
#include <torch/script.h>

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string_view>

#include "torch_network.hpp"

namespace pusht {
namespace {

/// Whether a node is a sum, a difference, a product or a quotient of tensors.
bool isArithmetic(const torch::jit::Node& node) {
  constexpr std::array<std::string_view, 4> kNames = {"aten::add", "aten::sub", "aten::mul", "aten::div"};
  const torch::jit::FunctionSchema* const schema = node.maybeSchema();
  return schema != nullptr && schema->overload_name() == "Tensor" &&
         std::find(kNames.begin(), kNames.end(), std::string_view(node.kind().toQualString())) != kNames.end();
}

/// The number that a constant of no dimension is; none for all else.
std::optional<c10::Scalar> numberIn(const torch::jit::Value* value) {
  const auto constant = torch::jit::toIValue(value);
  if (!constant || !constant->isTensor() || !constant->toTensor().defined() || constant->toTensor().dim() != 0) {
    return std::nullopt;
  }
  return constant->toTensor().item();
}

void restoreIn(torch::jit::Block& block) {
  for (torch::jit::Node* node : block.nodes()) {
    for (torch::jit::Block* inner : node->blocks()) {
      restoreIn(*inner);
    }
    const auto number = isArithmetic(*node) ? numberIn(node->input(1)) : std::nullopt;
    if (number) {
      const torch::jit::WithInsertPoint here(node);
      node->replaceInput(1, node->owningGraph()->insertConstant(*number));
    }
  }
}

}  // namespace

void restoreTracedNumbers(const torch::jit::Module& module) {
  for (const torch::jit::Module& part : module.modules()) {
    for (const torch::jit::Method& method : part.get_methods()) {
      restoreIn(*method.graph()->block());
    }
  }
}

}  // namespace pusht
