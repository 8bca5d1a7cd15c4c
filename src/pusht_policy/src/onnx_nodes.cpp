// SPDX-License-Identifier: BSD-3-Clause
#include "onnx_nodes.hpp"

#include <onnx/onnx_pb.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

#include "pusht_task/error.hpp"

namespace pusht {
namespace {

using Kind = Operation::Kind;
using onnx::NodeProto;
using onnx::TensorProto;

const onnx::AttributeProto* attributeOf(const NodeProto& node, const char* name) {
  const auto found = std::find_if(node.attribute().begin(), node.attribute().end(),
                                  [&](const onnx::AttributeProto& attribute) { return attribute.name() == name; });
  return found == node.attribute().end() ? nullptr : &*found;
}

float floatOf(const NodeProto& node, const char* name, float otherwise) {
  const onnx::AttributeProto* const attribute = attributeOf(node, name);
  if (attribute != nullptr && (!attribute->has_f() || !std::isfinite(attribute->f()))) {
    throw UnfitForKernel(std::string("its ") + name + " must be a finite number");
  }
  return attribute == nullptr ? otherwise : attribute->f();
}

std::int64_t integerOf(const NodeProto& node, const char* name, std::int64_t otherwise) {
  const onnx::AttributeProto* const attribute = attributeOf(node, name);
  if (attribute != nullptr && !attribute->has_i()) {
    throw UnfitForKernel(std::string("its ") + name + " must be an integer");
  }
  return attribute == nullptr ? otherwise : attribute->i();
}

/// `tensor` times a number, in float32.
FloatTensor multiplied(FloatTensor tensor, float factor) {
  for (float& value : tensor.values) {
    value *= factor;
  }
  return tensor;
}

}  // namespace

const std::map<std::string, OnnxReader::Operator>& OnnxReader::operators() {
  static const std::map<std::string, Operator> table = {
      {"Add", {&OnnxReader::readAdd, 2, 2, {}}},
      {"Cast", {&OnnxReader::readCast, 1, 1, {"to", "saturate"}}},
      {"Clip", {&OnnxReader::readClip, 1, 3, {"min", "max"}}},
      {"Constant",
       {nullptr,
        0,
        0,
        {"value", "value_float", "value_floats", "value_int", "value_ints", "value_string", "value_strings",
         "sparse_value"}}},
      {"Div", {&OnnxReader::readDiv, 2, 2, {}}},
      {"Dropout", {&OnnxReader::readDropout, 1, 3, {"ratio", "seed"}}},
      {"Flatten", {&OnnxReader::readFlatten, 1, 1, {"axis"}}},
      {"Gemm", {&OnnxReader::readGemm, 2, 3, {"alpha", "beta", "transA", "transB"}}},
      {"Identity", {&OnnxReader::readIdentity, 1, 1, {}}},
      {"MatMul", {&OnnxReader::readMatMul, 2, 2, {}}},
      {"Max", {&OnnxReader::readMax, 2, 2, {}}},
      {"Min", {&OnnxReader::readMin, 2, 2, {}}},
      {"Mul", {&OnnxReader::readMul, 2, 2, {}}},
      {"Neg", {&OnnxReader::readNeg, 1, 1, {}}},
      {"Relu", {&OnnxReader::readRelu, 1, 1, {}}},
      {"Reshape", {&OnnxReader::readReshape, 2, 2, {"allowzero"}}},
      {"Sub", {&OnnxReader::readSub, 2, 2, {}}},
      {"Tanh", {&OnnxReader::readTanh, 1, 1, {}}},
      {"Transpose", {nullptr, 1, 1, {"perm"}}},
  };
  return table;
}

const OnnxReader::Operator& OnnxReader::operatorOf(const NodeProto& node) {
  const auto found = operators().find(isStandard(node.domain()) ? node.op_type() : "");
  if (found == operators().end()) {
    throw UnfitForKernel("is not known to the kernel");
  }
  const auto& [read, fewest, most, attributes] = found->second;
  if (node.input_size() < fewest || node.input_size() > most || node.output_size() < 1) {
    throw UnfitForKernel("must have " + std::to_string(fewest) + " to " + std::to_string(most) +
                         " inputs and an output, but has " + std::to_string(node.input_size()) + " inputs");
  }
  for (const onnx::AttributeProto& attribute : node.attribute()) {
    if (attributes.count(attribute.name()) == 0 || attribute.has_ref_attr_name()) {
      throw UnfitForKernel("its attribute " + quoted(attribute.name()) + " is not known to the kernel");
    }
  }
  return found->second;
}

void OnnxReader::define(const std::string& name) {
  if (name.empty() || !names_.insert(name).second) {
    throw InvalidInput("name " + quoted(name) + ": must be given to one tensor");
  }
}

void OnnxReader::addConstant(const std::string& name, OnnxConstant constant) {
  define(name);
  constants_.emplace(name, std::make_shared<const OnnxConstant>(std::move(constant)));
}

void OnnxReader::read(const NodeProto& node, int index) {
  const std::string name = node.name().empty() ? std::to_string(index) : quoted(node.name());
  try {
    const Operator& known = operatorOf(node);
    for (const std::string& output : node.output()) {
      if (&output == &node.output(0) || !output.empty()) {
        define(output);
      }
    }
    if (const Constant constant = folded(node)) {
      folded_ += constant->tensor.values.size();
      requireRoom();
      constants_.emplace(node.output(0), constant);
    } else if (known.read == nullptr) {
      throw UnfitForKernel("must be of a constant");
    } else {
      (this->*known.read)(node);
      requireRoom();
      rows_ = node.output(0);
    }
  } catch (const UnfitForKernel& error) {
    const std::string domain = isStandard(node.domain()) ? "" : node.domain() + ".";
    throw UnfitForKernel("operator " + quoted(domain + node.op_type()) + " of node " + name + ": " + error.what());
  }
}

void OnnxReader::requireRoom() const {
  constexpr std::size_t kMostNumbers = std::size_t{1} << 26U;  // 268 MB; a small file may use one matrix many times
  if (list_.numbers() + folded_ > kMostNumbers) {
    throw UnfitForKernel("the network must have at most " + std::to_string(kMostNumbers) + " numbers up to here");
  }
}

/// Constant that `node` makes of constants; null if it makes none.
OnnxReader::Constant OnnxReader::folded(const NodeProto& node) const {
  if (node.op_type() == "Constant") {
    return std::make_shared<const OnnxConstant>(readConstantNode(node));
  }
  const auto found = constants_.find(node.input(0));
  if (found == constants_.end()) {
    return nullptr;
  }
  const Constant& constant = found->second;
  if (node.op_type() == "Identity") {
    return constant;
  }
  if (node.op_type() == "Cast" && integerOf(node, "to", 0) == TensorProto::FLOAT) {
    return std::make_shared<const OnnxConstant>(castToFloat(*constant));
  }
  if (node.op_type() == "Transpose" && constant->type == TensorProto::FLOAT) {
    const onnx::AttributeProto* const order = attributeOf(node, "perm");
    if (order != nullptr && (order->ints_size() != 2 || order->ints(0) != 1 || order->ints(1) != 0)) {
      throw UnfitForKernel("its perm must exchange two dimensions");
    }
    return std::make_shared<const OnnxConstant>(OnnxConstant{TensorProto::FLOAT, transposed(constant->tensor), {}});
  }
  return nullptr;
}

bool OnnxReader::has(const NodeProto& node, int input) {
  return input < node.input_size() && !node.input(input).empty();
}

void OnnxReader::requireRows(const NodeProto& node) const {
  if (node.input(0) != rows_) {
    throw UnfitForKernel("must take the result of the operation before it");
  }
}

OnnxReader::Constant OnnxReader::constantAt(const NodeProto& node, int input) const {
  const auto found = constants_.find(node.input(input));
  if (found == constants_.end()) {
    throw UnfitForKernel("its operand " + quoted(node.input(input)) + " must be constant");
  }
  return found->second;
}

const FloatTensor& OnnxReader::operand(const NodeProto& node, int input) const {
  const Constant constant = constantAt(node, input);
  if (constant->type != TensorProto::FLOAT) {
    throw UnfitForKernel("its operand " + quoted(node.input(input)) + " must be float32");
  }
  return constant->tensor;
}

/// Operand of `node` that is not the rows.
const FloatTensor& OnnxReader::otherOperand(const NodeProto& node) const {
  if (node.input(1) == rows_) {
    return operand(node, 0);
  }
  requireRows(node);
  return operand(node, 1);
}

void OnnxReader::readGemm(const NodeProto& node) {
  requireRows(node);
  if (integerOf(node, "transA", 0) != 0) {
    throw UnfitForKernel("its transA must be 0");
  }
  const FloatTensor& matrix = operand(node, 1);
  list_.appendMatrix(integerOf(node, "transB", 0) != 0 ? transposed(matrix) : matrix);
  if (const float alpha = floatOf(node, "alpha", 1.0F); alpha != 1.0F) {
    list_.append(Kind::kMultiply, scalar(alpha));
  }
  if (has(node, 2)) {
    list_.append(Kind::kAdd, multiplied(operand(node, 2), floatOf(node, "beta", 1.0F)));
  }
}

void OnnxReader::readMatMul(const NodeProto& node) {
  requireRows(node);
  list_.appendMatrix(operand(node, 1));
}

void OnnxReader::readAdd(const NodeProto& node) { list_.append(Kind::kAdd, otherOperand(node)); }

void OnnxReader::readMul(const NodeProto& node) { list_.append(Kind::kMultiply, otherOperand(node)); }

void OnnxReader::readMax(const NodeProto& node) { list_.append(Kind::kMax, otherOperand(node)); }

void OnnxReader::readMin(const NodeProto& node) { list_.append(Kind::kMin, otherOperand(node)); }

void OnnxReader::readSub(const NodeProto& node) {
  if (node.input(1) == rows_) {
    list_.appendSubtractionFrom(operand(node, 0));
  } else {
    list_.append(Kind::kSubtract, otherOperand(node));
  }
}

void OnnxReader::readDiv(const NodeProto& node) {
  requireRows(node);
  list_.append(Kind::kDivide, operand(node, 1));
}

void OnnxReader::readNeg(const NodeProto& node) {
  requireRows(node);
  list_.appendNegation();
}

void OnnxReader::readRelu(const NodeProto& node) {
  requireRows(node);
  list_.append(Kind::kMax, scalar(0.0F));
}

void OnnxReader::readTanh(const NodeProto& node) {
  requireRows(node);
  list_.appendTanh();
}

/// Bounds are attributes before opset 11, inputs from then on.
void OnnxReader::readClip(const NodeProto& node) {
  constexpr std::int64_t kInputsSince = 11;
  requireRows(node);
  if (opset_ < kInputsSince ? node.input_size() > 1 : node.attribute_size() > 0) {
    throw UnfitForKernel("its bounds must be " + std::string(opset_ < kInputsSince ? "attributes" : "inputs") +
                         " in opset " + std::to_string(opset_));
  }
  for (const auto& [kind, name, input] : {std::tuple(Kind::kMax, "min", 1), std::tuple(Kind::kMin, "max", 2)}) {
    if (attributeOf(node, name) != nullptr) {
      list_.append(kind, scalar(floatOf(node, name, 0.0F)));
    } else if (has(node, input)) {
      list_.append(kind, operand(node, input));
    }
  }
}

void OnnxReader::readCast(const NodeProto& node) {
  requireRows(node);
  if (integerOf(node, "to", 0) != TensorProto::FLOAT) {
    throw UnfitForKernel("must keep float32");
  }
}

/// In inference it changes nothing; since opset 12 an input says whether it is in training.
void OnnxReader::readDropout(const NodeProto& node) {
  constexpr int kTrains = 2;
  requireRows(node);
  if (has(node, kTrains) && constantAt(node, kTrains)->numbers != std::vector<double>{0.0}) {
    throw UnfitForKernel("must be off");
  }
}

void OnnxReader::readFlatten(const NodeProto& node) {
  requireRows(node);
  if (const std::int64_t axis = integerOf(node, "axis", 1); axis != 1 && axis != -1) {
    throw UnfitForKernel("must keep the shape of the rows");
  }
}

void OnnxReader::readIdentity(const NodeProto& node) { requireRows(node); }

/// A number of rows that is written as 1 means the single row that the network was exported for.
void OnnxReader::readReshape(const NodeProto& node) {
  requireRows(node);
  const std::vector<double>& shape = constantAt(node, 1)->numbers;
  const bool zero_keeps = integerOf(node, "allowzero", 0) == 0;
  const auto keeps = [&](double dimension, double size) {
    return dimension == -1.0 || dimension == size || (dimension == 0.0 && zero_keeps);
  };
  if (shape.size() != 2 || !keeps(shape[0], 1.0) || !keeps(shape[1], list_.columns()) ||
      (shape[0] == -1.0 && shape[1] == -1.0)) {
    throw UnfitForKernel("must keep the shape of the rows");
  }
}

}  // namespace pusht
