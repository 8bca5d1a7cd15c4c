// SPDX-License-Identifier: BSD-3-Clause
/// Constants of an ONNX model: its initializers and what its Constant nodes hold.
#pragma once

#include <string>
#include <vector>

#include "operation_list.hpp"

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

/// Name in a file, for a message of one line: at most 80 characters that can be printed, in quotes.
std::string quoted(const std::string& name);

/// Shape for a message: "[512, 10]".
std::string textOf(const std::vector<std::int64_t>& shape);

/// Reads a tensor. Throws InvalidInput, naming it, if a dimension is negative, it does not hold exactly the values of
/// its shape, or its data are in another file; BadDependency if a value is not finite.
OnnxConstant readTensor(const onnx::TensorProto& tensor, const std::string& name);

/// Reads the constant of a Constant node: a tensor, a number or a list of numbers. Throws as readTensor(), and
/// UnfitForKernel for anything else.
OnnxConstant readConstantNode(const onnx::NodeProto& node);

/// The constant as FLOAT. Throws UnfitForKernel unless it has values, BadDependency if they are too large.
OnnxConstant castToFloat(const OnnxConstant& constant);

}  // namespace pusht
