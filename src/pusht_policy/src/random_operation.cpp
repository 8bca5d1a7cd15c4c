// SPDX-License-Identifier: BSD-3-Clause
#include <torch/script.h>

#include <algorithm>
#include <optional>

#include "torch_network.hpp"

namespace pusht {
namespace {

/// Whether an operation is told that the network is trained, or that it is not; empty if it is not told.
std::optional<bool> isTold(const torch::jit::Node& node) {
  if (node.maybeSchema() == nullptr) {
    return {};
  }
  for (const char* const name : {"train", "training"}) {
    if (node.hasNamedInput(name)) {
      const auto train = torch::jit::toIValue(node.namedInput(name));
      return train && train->isBool() ? std::optional<bool>(train->toBool()) : std::nullopt;
    }
  }
  return {};
}

/// Whether an operation that has a dropout of its own, as attention has in torch 2, is told to drop nothing.
bool dropsNothing(const torch::jit::Node& node) {
  constexpr const char* kShare = "dropout_p";
  if (!node.hasNamedInput(kShare)) {
    return false;
  }
  const auto share = torch::jit::toIValue(node.namedInput(kShare));
  return share && share->isDouble() && share->toDouble() == 0.0;
}

/// Whether an operation may draw random numbers. libtorch's own list misses those in place; they take a generator.
bool drawsNumbers(const torch::jit::Node& node) {
  const torch::jit::FunctionSchema* const schema = node.maybeSchema();
  if (schema == nullptr || isTold(node) == false || dropsNothing(node)) {
    return false;
  }
  const auto& arguments = schema->arguments();
  return node.isNondeterministic() || std::any_of(arguments.begin(), arguments.end(), [](const auto& argument) {
           return argument.type()->isSubtypeOf(*c10::OptionalType::create(c10::GeneratorType::get()));
         });
}

/// First operation in a block, or in a block within, that is such.
std::string findOperation(const torch::jit::Block& block, bool (*is_such)(const torch::jit::Node& node)) {
  for (const torch::jit::Node* node : block.nodes()) {
    std::string name = is_such(*node) ? node->kind().toQualString() : "";
    for (const torch::jit::Block* inner : node->blocks()) {
      name = name.empty() ? findOperation(*inner, is_such) : name;
    }
    if (!name.empty()) {
      return name;
    }
  }
  return "";
}

/// Finds a constant that names a device that is not the CPU.
void findConstants(const torch::jit::Block& block, std::string& device) {
  for (const torch::jit::Node* node : block.nodes()) {
    const auto value = node->outputs().size() == 1 ? torch::jit::toIValue(node->output()) : c10::nullopt;
    if (value && value->isDevice() && !value->toDevice().is_cpu()) {
      device = value->toDevice().str();
    } else if (value && value->isString() && value->toStringRef().rfind("cuda", 0) == 0) {
      device = value->toStringRef();
    }
    for (const torch::jit::Block* inner : node->blocks()) {
      findConstants(*inner, device);
    }
  }
}

}  // namespace

std::string randomOperationIn(const torch::jit::Graph& graph) { return findOperation(*graph.block(), drawsNumbers); }

std::string trainingOperationIn(const torch::jit::Graph& graph) {
  return findOperation(*graph.block(), [](const torch::jit::Node& node) { return isTold(node) == true; });
}

std::string otherDeviceIn(const torch::jit::Graph& graph) {
  std::string device;
  findConstants(*graph.block(), device);
  return device;
}

}  // namespace pusht
