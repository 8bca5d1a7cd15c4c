// SPDX-License-Identifier: BSD-3-Clause
/// libtorch itself, to compare networks with.
#pragma once

#include <torch/script.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pusht_task/types.hpp"

namespace pusht::testing {

/// Writes a checkpoint without parameters that has this method forward, and this description.
inline void writeNetwork(const std::filesystem::path& path, const std::string& forward,
                         const std::string& description) {
  torch::jit::Module module("Policy");
  module.register_buffer("calls", torch::zeros({1}));
  module.define(forward);
  module.save(path.string(), {{"policy.json", description}, {"notes.txt", "no concern of the suite"}});
}

/// What libtorch itself makes of float32 rows, one at a time, in the order in which the module was written.
template <class Forward>
std::vector<float> onLibtorch(Forward forward, Span<const float> rows, std::int64_t columns) {
  const torch::NoGradGuard no_gradients;
  const torch::jit::GraphOptimizerEnabledGuard as_written(false);
  std::vector<float> results;
  for (std::size_t first = 0; first < rows.size(); first += columns) {
    const torch::Tensor row = torch::empty({1, columns});
    std::copy_n(rows.data() + first, columns, row.data_ptr<float>());
    const torch::Tensor result = torch::Tensor(forward(row)).contiguous();
    results.insert(results.end(), result.data_ptr<float>(), result.data_ptr<float>() + result.numel());
  }
  return results;
}

}  // namespace pusht::testing
