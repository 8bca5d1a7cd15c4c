// SPDX-License-Identifier: BSD-3-Clause
/// Constants of an ONNX model: its initializers and what its Constant nodes hold.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "network_builder.hpp"

namespace onnx {
class NodeProto;
class TensorProto;
}  // namespace onnx

namespace pusht {

/// Constant of an ONNX model. One of a type that the reader does not know has a shape only.
struct OnnxConstant {
  int type = 0;                 ///< onnx::TensorProto::DataType
  FloatTensor tensor;           ///< shape of every type; the values of FLOAT
  std::vector<double> numbers;  ///< the values of DOUBLE, INT32, INT64 and BOOL
};

/// Files beside a model that have values of its tensors (external data).
class OnnxDataFiles {
 public:
  explicit OnnxDataFiles(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// Bytes that the tensor says it has there. Throws InvalidInput, beginning with `where`, if the file is not one in
  /// the folder of the model, cannot be read, or does not have them.
  std::string bytesOf(const onnx::TensorProto& tensor, const std::string& where);

  /// SHA-256 of each file that was read.
  std::map<std::string, std::string> hashes() const;

 private:
  std::filesystem::path folder_;
  std::map<std::string, std::string> contents_;
};

/// Name in a file, for a message of one line: at most 80 characters that can be printed, in quotes.
std::string quoted(const std::string& name);

/// Shape for a message: "[512, 10]".
std::string textOf(const std::vector<std::int64_t>& shape);

/// Reads a tensor. Throws InvalidInput, naming it, if a dimension is negative or it does not hold exactly the values of
/// its shape, and as OnnxDataFiles does; BadDependency if a value is not finite.
OnnxConstant readTensor(const onnx::TensorProto& tensor, const std::string& name, OnnxDataFiles& files);

/// Reads the constant of a Constant node: a tensor, a number or a list of numbers. Throws as readTensor(), and
/// UnfitForKernel for anything else.
OnnxConstant readConstantNode(const onnx::NodeProto& node, OnnxDataFiles& files);

/// The constant as FLOAT. Throws UnfitForKernel unless it has values, BadDependency if they are too large.
OnnxConstant castToFloat(const OnnxConstant& constant);

}  // namespace pusht
