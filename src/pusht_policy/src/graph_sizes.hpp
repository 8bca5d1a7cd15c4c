// SPDX-License-Identifier: BSD-3-Clause
/// Sizes in a TorchScript graph: what a reshape is given may be computed from the shape of an earlier result.
#pragma once

#include <torch/script.h>

#include <map>
#include <optional>

#include "operation_list.hpp"

namespace pusht {

/// Shapes of the results of a graph that are known, and values that are constant with them.
class GraphSizes {
 public:
  /// Whether an operation only computes sizes: valueOf() follows it.
  static bool areComputedBy(const torch::jit::Node& node);

  void set(const torch::jit::Value* result, const Sizes& shape) { shapes_[result] = shape; }

  /// Value of a constant, or of what is computed from known shapes; empty for others.
  std::optional<torch::jit::IValue> valueOf(const torch::jit::Value* value) const;

 private:
  std::optional<torch::jit::IValue> sizeOf(const torch::jit::Node& node) const;

  std::map<const torch::jit::Value*, Sizes> shapes_;
};

}  // namespace pusht
