// SPDX-License-Identifier: BSD-3-Clause
/// Nodes of an ONNX graph as operations of the kernel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "network_layers.hpp"
#include "onnx_constants.hpp"
#include "unfit_operations.hpp"

namespace pusht {

/// Whether a domain is that of ONNX's own operators.
inline bool isStandard(const std::string& domain) { return domain.empty() || domain == "ai.onnx"; }

/// Reads one node after the other. What it cannot read is collected, and with it what depends on that.
class OnnxReader {
 public:
  /// Inputs have these shapes for one rollout.
  OnnxReader(const std::vector<std::string>& inputs, const std::vector<Sizes>& shapes, std::int64_t opset,
             OnnxDataFiles& files);

  void addConstant(const std::string& name, OnnxConstant constant);

  /// Throws InvalidInput if a name is given twice, BadDependency if a number is not finite.
  void read(const onnx::NodeProto& node, int index);

  /// Shape of a result. Throws UnfitForKernel, naming all operators that could not be read, or if there is no such.
  const Sizes& shapeOf(const std::string& result) const;
  std::vector<Operation> finish(const std::vector<std::string>& results);

 private:
  using Node = onnx::NodeProto;

  /// Float32 tensor, or a constant of another type.
  struct Value {
    NetworkTensor tensor;
    std::shared_ptr<const OnnxConstant> other{};  ///< null for float32

    const Sizes& shape() const { return other != nullptr ? other->tensor.shape : tensor.shape; }
  };
  using Values = std::vector<Value>;
  using Reader = Values (OnnxReader::*)(const Node&);

  struct Operator {
    Reader read;
    int fewest_inputs;
    int most_inputs;
    std::set<std::string_view> attributes;
  };
  static const std::map<std::string, Operator>& operators();
  static void addTo(std::map<std::string, Operator>& table);
  void readKnown(const Operator& known, const Node& node);

  // Operands.
  void define(const std::string& name);
  static bool has(const Node& node, int input) { return input < node.input_size() && !node.input(input).empty(); }
  const Value& value(const Node& node, int input) const;
  const NetworkTensor& tensor(const Node& node, int input) const;
  const FloatTensor& constant(const Node& node, int input) const;
  const std::vector<double>& numbers(const Node& node, int input) const;
  Sizes integers(const Node& node, int input) const;
  Sizes axesOf(const Node& node, std::int64_t inputs_since, const Value& of) const;
  void requireRoom();

  static Values one(NetworkTensor tensor) { return {Value{std::move(tensor)}}; }
  static Value number(OnnxConstant constant);
  Value select(const Value& value, const Selection& selection);
  Value reshaped(const Value& value, Sizes shape) {
    return select(value, {std::move(shape), allOf(value.shape()).elements});
  }

  template <Operation::Kind kKind>
  Values readFunction(const Node& node) {
    return one(network_.apply(kKind, tensor(node, 0)));
  }
  template <NetworkTensor (NetworkLayers::*kLayer)(const NetworkTensor&)>
  Values readLayer(const Node& node) {
    return one((layers_.*kLayer)(tensor(node, 0)));
  }
  template <Operation::Kind kKind>
  Values readCombination(const Node& node);
  Values combineNumbers(const Node& node, Operation::Kind kind);

  // Arithmetic.
  Values readGemm(const Node& node);
  Values readMatMul(const Node& node);
  Values readPow(const Node& node);
  Values readReciprocal(const Node& node);
  Values readRelu(const Node& node);
  Values readClip(const Node& node);
  Values readElu(const Node& node);
  Values readCelu(const Node& node);
  Values readSelu(const Node& node);
  Values readGelu(const Node& node);
  Values readLeakyRelu(const Node& node);
  Values readPRelu(const Node& node);
  Values readHardSigmoid(const Node& node);
  Values readSoftsign(const Node& node);
  Values readReduceMean(const Node& node);
  Values readReduceSum(const Node& node);
  Values reduced(const Node& node, std::int64_t axes_are_inputs_since, bool mean);
  Values readLayerNormalization(const Node& node);
  Values readBatchNormalization(const Node& node);
  Values readRecurrent(const Node& node);
  NetworkLayers::CellWeights cellWeights(const Node& node, const std::vector<std::size_t>& order);
  NetworkTensor reordered(const NetworkTensor& gates, const std::vector<std::size_t>& order);

  // Movement, and constants of shapes.
  Values readConstant(const Node& node);
  Values readConstantOfShape(const Node& node);
  Values readShape(const Node& node);
  Values readCast(const Node& node);
  Values readDropout(const Node& node);
  Values readIdentity(const Node& node) { return {value(node, 0)}; }
  Values readFlatten(const Node& node);
  Values readReshape(const Node& node);
  Values readSqueeze(const Node& node);
  Values readUnsqueeze(const Node& node);
  Values readTranspose(const Node& node);
  Values readExpand(const Node& node);
  Values readConcat(const Node& node);
  Values readSplit(const Node& node);
  Values readSlice(const Node& node);
  Values readGather(const Node& node);

  std::int64_t opset_;
  OnnxDataFiles& files_;
  NetworkBuilder network_;
  NetworkLayers layers_{network_};
  std::map<std::string, Value> values_;
  std::set<std::string> names_;
  std::set<std::string> unknown_;  // results of operators that could not be read
  std::set<std::string> unknown_operators_;
  UnfitOperations unfit_;
  std::size_t other_numbers_ = 0;  // of constants that are not float32
};

// Attributes of nodes. They throw UnfitForKernel if one is of another type.
float floatOf(const onnx::NodeProto& node, const char* name, float otherwise);
std::int64_t integerOf(const onnx::NodeProto& node, const char* name, std::int64_t otherwise);
/// Empty if there is none.
std::string textOf(const onnx::NodeProto& node, const char* name);
bool hasAttribute(const onnx::NodeProto& node, const char* name);
/// Empty if there is none.
Sizes integersOf(const onnx::NodeProto& node, const char* name);

}  // namespace pusht
