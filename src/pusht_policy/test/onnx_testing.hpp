// SPDX-License-Identifier: BSD-3-Clause
/// ONNX models for tests, written with ONNX's own library.
#pragma once

#include <google/protobuf/text_format.h>
#include <onnx/onnx_pb.h>

#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include "network_testing.hpp"

namespace pusht::testing {

/// Adds a float32 tensor with its values as raw bytes, as torch's exporter writes it.
inline onnx::TensorProto& addTensor(onnx::GraphProto& graph, const std::string& name,
                                    const std::vector<std::int64_t>& shape, const std::vector<float>& values) {
  onnx::TensorProto& tensor = *graph.add_initializer();
  tensor.set_name(name);
  tensor.set_data_type(onnx::TensorProto::FLOAT);
  for (const std::int64_t dimension : shape) {
    tensor.add_dims(dimension);
  }
  tensor.mutable_raw_data()->assign(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float));
  return tensor;
}

/// Model with weights for all tests, whose nodes are written as protobuf's text: from x [n, 10] to y [n, 2].
inline onnx::ModelProto onnxModel(const std::string& nodes, std::int64_t opset = 14) {
  constexpr int kHidden = 24;
  NumpyGenerator generator(11);
  onnx::ModelProto model;
  model.set_ir_version(7);
  model.set_producer_name("test");
  model.set_producer_version("1");
  model.add_opset_import()->set_version(opset);
  const std::string text =
      "input { name: 'x' type { tensor_type { elem_type: 1 shape { dim { dim_param: 'n' } dim { "
      "dim_value: 10 } } } } } output { name: 'y' type { tensor_type { elem_type: 1 shape { dim "
      "{ dim_param: 'n' } dim { dim_value: 2 } } } } } " +
      nodes;
  if (!google::protobuf::TextFormat::ParseFromString(text, model.mutable_graph())) {
    throw std::invalid_argument("no graph of ONNX: " + text);
  }
  const std::vector<std::pair<std::string, std::vector<std::int64_t>>> tensors = {
      {"w", {10, 2}},    {"w_t", {2, 10}},     {"b", {2}},    {"row", {1, 2}}, {"w0", {10, kHidden}},
      {"b0", {kHidden}}, {"w1", {kHidden, 2}}, {"low", {10}}, {"number", {}},  {"one", {1}},
  };
  for (const auto& [name, shape] : tensors) {
    std::size_t count = 1;
    for (const std::int64_t dimension : shape) {
      count *= static_cast<std::size_t>(dimension);
    }
    addTensor(*model.mutable_graph(), name, shape, randomValues(generator, count, 0.5));
  }
  return model;
}

/// Node as protobuf's text: op("Gemm", {"x", "w", "b"}, "y", "attribute {...}").
inline std::string op(const std::string& type, const std::vector<std::string>& inputs, const std::string& output,
                      const std::string& more = "") {
  std::string text = "node { op_type: '" + type + "' name: '/" + type + "' output: '" + output + "' ";
  for (const std::string& input : inputs) {
    text += "input: '" + input + "' ";
  }
  return text + more + " } ";
}

/// Attribute that is a float, or an integer, as protobuf's text.
inline std::string realAttribute(const std::string& name, const std::string& value) {
  return "attribute { name: '" + name + "' type: FLOAT f: " + value + " } ";
}
inline std::string integerAttribute(const std::string& name, const std::string& value) {
  return "attribute { name: '" + name + "' type: INT i: " + value + " } ";
}
/// Attribute of a Constant node: a tensor.
inline std::string tensorAttribute(const std::string& tensor) {
  return "attribute { name: 'value' type: TENSOR t { " + tensor + " } } ";
}

}  // namespace pusht::testing
