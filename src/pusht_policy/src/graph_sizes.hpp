// SPDX-License-Identifier: BSD-3-Clause
/// Values in a TorchScript graph that are no tensors: constants, and what is computed from the shapes of tensors.
#pragma once

#include <torch/script.h>

#include <map>
#include <optional>

#include "network_builder.hpp"

namespace pusht {

/// Shapes of the tensors of a graph, and values that are constant with them.
class GraphSizes {
 public:
  /// Whether the results of an operation are no tensors: valueOf() computes them when they are asked for.
  static bool areComputedBy(const torch::jit::Node& node);

  void set(const torch::jit::Value* tensor, const Sizes& shape) { shapes_[tensor] = shape; }

  /// Result of a branch that is another value, no tensor.
  void setSame(const torch::jit::Value* result, const torch::jit::Value* other) { same_[result] = other; }

  /// Value of a constant, or of what is computed from known shapes and constants; empty for others.
  std::optional<torch::jit::IValue> valueOf(const torch::jit::Value* value) const;

 private:
  std::optional<torch::jit::IValue> computed(const torch::jit::Node& node) const;

  std::map<const torch::jit::Value*, Sizes> shapes_;
  std::map<const torch::jit::Value*, const torch::jit::Value*> same_;
};

}  // namespace pusht
