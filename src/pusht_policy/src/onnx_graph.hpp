// SPDX-License-Identifier: BSD-3-Clause
/// Reader of ONNX models, as far as they are a sequence of the kernel's operations.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "pusht_policy/network_kernel.hpp"

namespace pusht {

/// Network of an ONNX file.
struct OnnxNetwork {
  std::vector<Operation> operations;
  std::int64_t opset;    ///< version of ONNX's operators that the file was written for
  std::string producer;  ///< program that wrote it, with its version: "pytorch 1.13.0"
};

/// Oldest and newest versions of ONNX's operators that are read. Before, operands had other shapes; after, operators
/// may mean something else.
constexpr std::int64_t kOldestOpset = 7;
constexpr std::int64_t kNewestOpset = 22;

/// Operations of the ONNX file `bytes`, which maps rows of `inputs` numbers to rows of `outputs`, in the file's own
/// order: alpha of a Gemm multiplies the product, beta the bias.
///
/// Throws InvalidInput if the bytes are no such file, or the network is no sequence of operations that the kernel
/// has; BadDependency if a number is not finite or a row has another width.
OnnxNetwork readOnnx(const std::string& bytes, int inputs, int outputs);

}  // namespace pusht
