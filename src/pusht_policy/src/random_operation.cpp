// SPDX-License-Identifier: BSD-3-Clause
#include <torch/script.h>

#include <algorithm>

#include "torch_network.hpp"

namespace pusht {
namespace {

/// Whether an operation is one of those that draw only while a network is trained, and it is not.
bool isAtRest(const torch::jit::Node& node) {
  for (const char* const name : {"train", "training"}) {
    if (node.hasNamedInput(name)) {
      const auto train = torch::jit::toIValue(node.namedInput(name));
      return train && train->isBool() && !train->toBool();
    }
  }
  return false;
}

/// Whether an operation may draw random numbers. libtorch's own list misses those in place; they take a generator.
bool drawsNumbers(const torch::jit::Node& node) {
  const torch::jit::FunctionSchema* const schema = node.maybeSchema();
  if (schema == nullptr || isAtRest(node)) {
    return false;
  }
  const auto& arguments = schema->arguments();
  return node.isNondeterministic() || std::any_of(arguments.begin(), arguments.end(), [](const auto& argument) {
           return argument.type()->isSubtypeOf(*c10::OptionalType::create(c10::GeneratorType::get()));
         });
}

std::string randomOperationInBlock(const torch::jit::Block& block) {
  for (const torch::jit::Node* node : block.nodes()) {
    std::string name = drawsNumbers(*node) ? node->kind().toQualString() : "";
    for (const torch::jit::Block* inner : node->blocks()) {
      name = name.empty() ? randomOperationInBlock(*inner) : name;
    }
    if (!name.empty()) {
      return name;
    }
  }
  return "";
}

}  // namespace

std::string randomOperationIn(const torch::jit::Graph& graph) { return randomOperationInBlock(*graph.block()); }

}  // namespace pusht
