// SPDX-License-Identifier: BSD-3-Clause
/// Reader of ONNX models, as far as they have the kernel's operations.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "pusht_policy/network_kernel.hpp"
#include "pusht_policy/policy_description.hpp"

namespace pusht {

/// Network of an ONNX file.
struct OnnxNetwork {
  std::vector<Operation> operations;  ///< from observations, state and noise, side by side, to actions and state
  PolicyDescription description;
  std::int64_t opset = 0;                         ///< version of ONNX's operators that the file was written for
  std::string producer;                           ///< program that wrote it, with its version: "pytorch 1.13.0"
  std::map<std::string, std::string> data_files;  ///< SHA-256 of each file beside it that has values of its tensors
};

/// Oldest and newest versions of ONNX's operators that are read. Before, operands had other shapes; after, operators
/// may mean something else.
constexpr std::int64_t kOldestOpset = 7;
constexpr std::int64_t kNewestOpset = 22;

/// Reads the ONNX file `bytes`, of which the metadata kDescriptionFile may be the description. Operations are in the
/// file's own order: alpha of a Gemm multiplies the product, beta the bias. `folder` is that of the file.
///
/// Throws InvalidInput if the bytes are no such file, or have operators that the kernel has not, naming all of them;
/// BadDependency if a number is not finite, or inputs and outputs are not those of the description.
OnnxNetwork readOnnx(const std::string& bytes, const std::filesystem::path& folder = {});

}  // namespace pusht
