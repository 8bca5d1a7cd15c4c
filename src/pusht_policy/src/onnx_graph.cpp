// SPDX-License-Identifier: BSD-3-Clause
#include "onnx_graph.hpp"

#include <onnx/onnx_pb.h>

#include <set>

#include "onnx_nodes.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/joined.hpp"

namespace pusht {
namespace {

using onnx::TensorProto;

/// Type for a message: "FLOAT [n, 10]".
std::string describe(const onnx::TypeProto::Tensor& tensor) {
  const int type = tensor.elem_type();
  std::vector<std::string> dimensions;
  for (const auto& dimension : tensor.shape().dim()) {
    constexpr int kEnough = 8;
    if (dimensions.size() == kEnough) {
      dimensions.emplace_back("...");
      break;
    }
    dimensions.push_back(dimension.has_dim_value()   ? std::to_string(dimension.dim_value())
                         : dimension.has_dim_param() ? quoted(dimension.dim_param())
                                                     : "?");
  }
  return (onnx::TensorProto_DataType_IsValid(type)
              ? onnx::TensorProto_DataType_Name(static_cast<onnx::TensorProto_DataType>(type))
              : "type " + std::to_string(type)) +
         (tensor.has_shape() ? " [" + (dimensions.empty() ? "" : joined(dimensions)) + "]" : " of any shape");
}

/// Throws BadDependency unless the value is declared as rows of `columns` float32 numbers, or one such row. What a
/// file leaves open about an output, the operations decide.
void requireRowsOf(int columns, const onnx::ValueInfoProto& value, bool is_input) {
  const onnx::TypeProto::Tensor& tensor = value.type().tensor_type();
  const auto allows = [&](int axis, std::int64_t size) {
    const auto& dimension = tensor.shape().dim(axis);
    return dimension.has_dim_value() ? dimension.dim_value() == size : (axis == 0 || !is_input);
  };
  const bool has_shape = tensor.has_shape() && tensor.shape().dim_size() == 2 && allows(0, 1) && allows(1, columns);
  if (tensor.elem_type() != TensorProto::FLOAT || !(has_shape || (!is_input && !tensor.has_shape()))) {
    throw BadDependency((is_input ? "input " : "output ") + quoted(value.name()) + ": must be FLOAT [n, " +
                        std::to_string(columns) + "] or [1, " + std::to_string(columns) + "], but is " +
                        (value.type().has_tensor_type() ? describe(tensor) : "no tensor"));
  }
}

/// Throws InvalidInput unless protobuf can read the bytes.
onnx::ModelProto parsed(const std::string& bytes) {
  if (bytes.empty()) {
    throw InvalidInput("must be ONNX, but is empty");
  }
  if (bytes.compare(0, 4, "PK\3\4") == 0) {
    throw InvalidInput("must be ONNX, as its name says, but is a zip archive, as TorchScript is: name it .ts.pt");
  }
  onnx::ModelProto model;
  if (!model.ParseFromString(bytes)) {
    throw InvalidInput("must be ONNX: protobuf cannot read it; it is cut off, damaged or something else");
  }
  return model;
}

/// Version of ONNX's operators. Throws InvalidInput if the model is of another time, or has operators of its own.
std::int64_t opsetOf(const onnx::ModelProto& model) {
  constexpr std::int64_t kOldestFormat = 3;   // since ONNX 1.0; the first whose operators have versions
  constexpr std::int64_t kNewestFormat = 10;  // ONNX 1.17
  if (model.ir_version() < kOldestFormat || model.ir_version() > kNewestFormat || !model.has_graph()) {
    throw InvalidInput("must be ONNX with a graph and ir_version " + std::to_string(kOldestFormat) + " to " +
                       std::to_string(kNewestFormat) + ", but has ir_version " + std::to_string(model.ir_version()));
  }
  if (model.functions_size() > 0) {
    throw InvalidInput("must have no functions of its own, but has " + quoted(model.functions(0).name()));
  }
  std::set<std::int64_t> opsets;
  for (const onnx::OperatorSetIdProto& import : model.opset_import()) {
    if (isStandard(import.domain())) {
      opsets.insert(import.version());
    }
  }
  if (opsets.size() != 1) {
    throw InvalidInput("must name one opset of ONNX, but names " + std::to_string(opsets.size()));
  }
  if (*opsets.begin() < kOldestOpset || *opsets.begin() > kNewestOpset) {
    throw InvalidInput("opset " + std::to_string(*opsets.begin()) + ": must be from " + std::to_string(kOldestOpset) +
                       " to " + std::to_string(kNewestOpset));
  }
  return *opsets.begin();
}

/// Only input of the graph that is no initializer: older files list those, too.
const onnx::ValueInfoProto& inputOf(const onnx::GraphProto& graph) {
  std::set<std::string> initializers;
  for (const TensorProto& tensor : graph.initializer()) {
    initializers.insert(tensor.name());
  }
  std::vector<const onnx::ValueInfoProto*> inputs;
  for (const onnx::ValueInfoProto& input : graph.input()) {
    if (initializers.count(input.name()) == 0) {
      inputs.push_back(&input);
    }
  }
  if (inputs.size() != 1 || graph.output_size() != 1) {
    throw BadDependency("must have one input and one output, but has " + std::to_string(inputs.size()) + " and " +
                        std::to_string(graph.output_size()));
  }
  return *inputs.front();
}

}  // namespace

OnnxNetwork readOnnx(const std::string& bytes, int inputs, int outputs) {
  const onnx::ModelProto model = parsed(bytes);
  const std::int64_t opset = opsetOf(model);
  const onnx::GraphProto& graph = model.graph();
  const onnx::ValueInfoProto& input = inputOf(graph);
  requireRowsOf(inputs, input, true);
  requireRowsOf(outputs, graph.output(0), false);
  try {
    OnnxReader reader(input.name(), inputs, opset);
    for (const TensorProto& tensor : graph.initializer()) {
      reader.addConstant(tensor.name(), readTensor(tensor, tensor.name()));
    }
    for (int i = 0; i < graph.node_size(); ++i) {
      reader.read(graph.node(i), i);
    }
    if (graph.output(0).name() != reader.rows()) {
      throw UnfitForKernel("output " + quoted(graph.output(0).name()) + ": must be the result of the last operation");
    }
    if (reader.list().columns() != outputs) {
      throw BadDependency("must map rows of " + std::to_string(inputs) + " numbers to rows of " +
                          std::to_string(outputs) + ", not to rows of " + std::to_string(reader.list().columns()));
    }
    return {reader.list().operations(), opset, model.producer_name() + " " + model.producer_version()};
  } catch (const UnfitForKernel& error) {
    throw InvalidInput(error.what() + std::string("; give a network that the kernel cannot run as TorchScript"));
  }
}

}  // namespace pusht
