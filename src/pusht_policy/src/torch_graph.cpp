// SPDX-License-Identifier: BSD-3-Clause
#include <torch/script.h>

#include <map>
#include <utility>

#include "graph_sizes.hpp"
#include "torch_network.hpp"

namespace pusht {
namespace {

using Kind = Operation::Kind;
using torch::jit::IValue;
using torch::jit::Node;
using torch::jit::Value;

FloatTensor floatTensor(const torch::Tensor& tensor) { return {tensor.sizes().vec(), toVector(tensor)}; }

/// Follows the row from operation to operation. It has a shape: element-wise operations extend their operand to it.
class GraphReader {
 public:
  GraphReader(const Value* rows, Sizes shape) : rows_(rows), list_(std::move(shape)) {
    sizes_.set(rows_, list_.shape());
  }

  void read(const Node& node);

  const Value* rows() const { return rows_; }
  const std::vector<Operation>& operations() const { return list_.operations(); }

 private:
  using Reader = void (GraphReader::*)(const Node&);
  static const std::map<std::string, Reader>& readers();

  void readLinear(const Node& node);
  void readAddmm(const Node& node);
  void readMatmul(const Node& node);
  void readAdd(const Node& node);
  void readSub(const Node& node);
  void readRsub(const Node& node);
  void readMul(const Node& node);
  void readDiv(const Node& node);
  void readNeg(const Node& node);
  void readRelu(const Node& node);
  void readRelu6(const Node& node);
  void readClamp(const Node& node);
  void readHardtanh(const Node& node);
  void readTanh(const Node& node);
  void readTo(const Node& node);
  void readDropout(const Node& node);
  void readCopy(const Node& node);
  void readFlatten(const Node& node);
  void readReshape(const Node& node);
  void readUnflatten(const Node& node);
  void readUnsqueeze(const Node& node);
  void readSqueeze(const Node& node);

  [[noreturn]] static void refuse(const Node& node, const std::string& why);
  IValue constant(const Node& node, const char* input) const;
  IValue otherConstant(const Node& node) const;
  void requireRows(const Node& node, const char* input) const;
  void requireOne(const Node& node, const char* input) const;

  void append(const Node& node, Kind kind, const IValue& operand);
  void appendMatrix(const Node& node, const IValue& matrix);

  torch::Tensor emptyRow() const { return torch::empty(list_.shape()); }
  void takeShape(const at::Tensor& like) { list_.reshape(like.sizes().vec()); }

  const Value* rows_;
  OperationList list_;
  GraphSizes sizes_;
};

const std::map<std::string, GraphReader::Reader>& GraphReader::readers() {
  static const std::map<std::string, Reader> table = {
      {"aten::linear", &GraphReader::readLinear},
      {"aten::addmm", &GraphReader::readAddmm},
      {"aten::matmul", &GraphReader::readMatmul},
      {"aten::add", &GraphReader::readAdd},
      {"aten::sub", &GraphReader::readSub},
      {"aten::rsub", &GraphReader::readRsub},
      {"aten::mul", &GraphReader::readMul},
      {"aten::div", &GraphReader::readDiv},
      {"aten::neg", &GraphReader::readNeg},
      {"aten::relu", &GraphReader::readRelu},
      {"aten::relu6", &GraphReader::readRelu6},
      {"aten::clamp", &GraphReader::readClamp},
      {"aten::clamp_min", &GraphReader::readClamp},
      {"aten::clamp_max", &GraphReader::readClamp},
      {"aten::hardtanh", &GraphReader::readHardtanh},
      {"aten::tanh", &GraphReader::readTanh},
      {"aten::to", &GraphReader::readTo},
      {"aten::dropout", &GraphReader::readDropout},
      {"aten::detach", &GraphReader::readCopy},
      {"aten::contiguous", &GraphReader::readCopy},
      {"aten::clone", &GraphReader::readCopy},
      {"aten::flatten", &GraphReader::readFlatten},
      {"aten::reshape", &GraphReader::readReshape},
      {"aten::view", &GraphReader::readReshape},
      {"aten::unflatten", &GraphReader::readUnflatten},
      {"aten::unsqueeze", &GraphReader::readUnsqueeze},
      {"aten::squeeze", &GraphReader::readSqueeze},
  };
  return table;
}

void GraphReader::refuse(const Node& node, const std::string& why) {
  throw UnfitForKernel(std::string(node.kind().toQualString()) + ": " + why);
}

void GraphReader::read(const Node& node) {
  std::string name = node.kind().toQualString();
  if (name.back() == '_') {  // in place: nothing else reads the rows, so that is no difference
    name.pop_back();
  }
  const auto reader = readers().find(name);
  if (reader == readers().end()) {
    refuse(node, "is not known to the kernel");
  }
  try {
    (this->*reader->second)(node);
  } catch (const UnfitOperand& error) {
    refuse(node, error.what());
  }
  rows_ = node.output();
  sizes_.set(rows_, list_.shape());
}

void GraphReader::requireRows(const Node& node, const char* input) const {
  if (node.namedInput(input) != rows_) {
    refuse(node, "must take the result of the operation before it");
  }
}

IValue GraphReader::constant(const Node& node, const char* input) const {
  const auto value = sizes_.valueOf(node.namedInput(input));
  if (!value) {
    refuse(node, std::string("its operand ") + input + " must be constant");
  }
  return *value;
}

/// Operand of `node` that is not the rows.
IValue GraphReader::otherConstant(const Node& node) const {
  if (node.namedInput("other") == rows_) {
    return constant(node, "self");
  }
  requireRows(node, "self");
  return constant(node, "other");
}

void GraphReader::requireOne(const Node& node, const char* input) const {
  const IValue value = constant(node, input);
  if (!value.isScalar() || value.toScalar().toDouble() != 1.0) {
    refuse(node, std::string("its ") + input + " must be 1");
  }
}

/// The operand is a number for all columns or a tensor with one for each.
void GraphReader::append(const Node& node, Kind kind, const IValue& operand) {
  if (!operand.isScalar() && !operand.isTensor()) {
    refuse(node, "its operand must be a number or a tensor");
  }
  torch::Tensor values = operand.isTensor() ? operand.toTensor() : torch::scalar_tensor(operand.toScalar());
  if (values.dim() == 0) {  // as torch takes it, whatever its type: in the type of the rows
    values = values.to(torch::kFloat32);
  }
  if (values.scalar_type() != torch::kFloat32) {
    refuse(node, "its operand must be float32");
  }
  list_.append(kind, floatTensor(values));
}

/// The matrix is [inputs, columns].
void GraphReader::appendMatrix(const Node& node, const IValue& matrix) {
  if (!matrix.isTensor() || matrix.toTensor().scalar_type() != torch::kFloat32) {
    refuse(node, "its matrix must be float32 for " + std::to_string(list_.columns()) + " inputs");
  }
  list_.appendMatrix(floatTensor(matrix.toTensor()));
}

void GraphReader::readLinear(const Node& node) {
  requireRows(node, "input");
  const IValue weight = constant(node, "weight");
  appendMatrix(node, weight.isTensor() ? weight.toTensor().t() : weight);
  const IValue bias = constant(node, "bias");
  if (!bias.isNone()) {
    append(node, Kind::kAdd, bias);
  }
}

void GraphReader::readAddmm(const Node& node) {
  requireRows(node, "mat1");
  requireOne(node, "beta");
  requireOne(node, "alpha");
  appendMatrix(node, constant(node, "mat2"));
  append(node, Kind::kAdd, constant(node, "self"));
}

void GraphReader::readMatmul(const Node& node) {
  requireRows(node, "self");
  appendMatrix(node, constant(node, "other"));
}

void GraphReader::readAdd(const Node& node) {
  requireOne(node, "alpha");
  append(node, Kind::kAdd, otherConstant(node));
}

void GraphReader::readSub(const Node& node) {
  if (node.namedInput("other") == rows_) {
    requireOne(node, "alpha");
    list_.appendNegation();  // c - x is -x + c to the last bit
    append(node, Kind::kAdd, constant(node, "self"));
  } else {
    requireRows(node, "self");
    requireOne(node, "alpha");
    append(node, Kind::kSubtract, constant(node, "other"));
  }
}

void GraphReader::readRsub(const Node& node) {
  requireRows(node, "self");
  requireOne(node, "alpha");
  list_.appendNegation();
  append(node, Kind::kAdd, constant(node, "other"));
}

void GraphReader::readMul(const Node& node) { append(node, Kind::kMultiply, otherConstant(node)); }

void GraphReader::readDiv(const Node& node) {
  requireRows(node, "self");
  if (node.hasNamedInput("rounding_mode") && !constant(node, "rounding_mode").isNone()) {
    refuse(node, "must not round");
  }
  append(node, Kind::kDivide, constant(node, "other"));
}

void GraphReader::readNeg(const Node& node) {
  requireRows(node, "self");
  list_.appendNegation();
}

void GraphReader::readRelu(const Node& node) {
  requireRows(node, "self");
  append(node, Kind::kMax, 0);
}

void GraphReader::readRelu6(const Node& node) {
  readRelu(node);
  append(node, Kind::kMin, 6);
}

void GraphReader::readClamp(const Node& node) {
  requireRows(node, "self");
  for (const auto& [input, kind] : {std::pair("min", Kind::kMax), std::pair("max", Kind::kMin)}) {
    if (node.hasNamedInput(input) && !constant(node, input).isNone()) {
      append(node, kind, constant(node, input));
    }
  }
}

void GraphReader::readHardtanh(const Node& node) {
  requireRows(node, "self");
  append(node, Kind::kMax, constant(node, "min_val"));
  append(node, Kind::kMin, constant(node, "max_val"));
}

void GraphReader::readTanh(const Node& node) {
  requireRows(node, "self");
  list_.appendTanh();
}

void GraphReader::readTo(const Node& node) {
  requireRows(node, "self");
  const IValue type = node.hasNamedInput("dtype") ? constant(node, "dtype") : IValue();
  if (node.hasNamedInput("other") || !(type.isNone() || type.toScalarType() == torch::kFloat32)) {
    refuse(node, "must keep float32");
  }
}

void GraphReader::readDropout(const Node& node) {
  requireRows(node, "input");
  if (constant(node, "train").toBool()) {
    refuse(node, "must be off");
  }
}

void GraphReader::readCopy(const Node& node) { requireRows(node, "self"); }

// Operations that change the shape of the row and move no number.

void GraphReader::readFlatten(const Node& node) {
  requireRows(node, "self");
  takeShape(emptyRow().flatten(constant(node, "start_dim").toInt(), constant(node, "end_dim").toInt()));
}

void GraphReader::readReshape(const Node& node) {
  requireRows(node, "self");
  takeShape(emptyRow().reshape(constant(node, node.hasNamedInput("shape") ? "shape" : "size").toIntVector()));
}

void GraphReader::readUnflatten(const Node& node) {
  requireRows(node, "self");
  const std::int64_t dim = constant(node, "dim").toInt();
  const Sizes parts = constant(node, "sizes").toIntVector();
  Sizes sizes = list_.shape();
  const auto place = sizes.erase(dim < 0 ? sizes.end() + dim : sizes.begin() + dim);
  sizes.insert(place, parts.begin(), parts.end());
  takeShape(emptyRow().reshape(sizes));
}

void GraphReader::readUnsqueeze(const Node& node) {
  requireRows(node, "self");
  takeShape(emptyRow().unsqueeze(constant(node, "dim").toInt()));
}

void GraphReader::readSqueeze(const Node& node) {
  requireRows(node, "self");
  const torch::Tensor like = emptyRow();
  takeShape(node.hasNamedInput("dim") ? like.squeeze(constant(node, "dim").toInt()) : like.squeeze());
}

/// Operations of a graph, as far as they can be read.
std::vector<Operation> readOperations(const torch::jit::Graph& graph, const Sizes& shape) {
  if (graph.inputs().size() != 2 || graph.outputs().size() != 1) {
    throw UnfitForKernel("forward must take one tensor and return one");
  }
  GraphReader reader(graph.inputs()[1], shape);
  for (const Node* node : graph.nodes()) {
    if (!GraphSizes::areComputedBy(*node)) {
      reader.read(*node);
    }
  }
  if (graph.outputs()[0] != reader.rows()) {
    throw UnfitForKernel("forward must return the result of its last operation");
  }
  return reader.operations();
}

}  // namespace

std::vector<float> toVector(const at::Tensor& tensor) {
  const torch::Tensor values = tensor.contiguous();
  return {values.data_ptr<float>(), values.data_ptr<float>() + values.numel()};
}

std::vector<Operation> readGraph(const torch::jit::Graph& graph, const Sizes& shape) {
  try {
    return readOperations(graph, shape);
  } catch (const UnfitForKernel&) {
    throw;
  } catch (const std::exception& error) {
    throw UnfitForKernel("cannot be read: " + firstLine(error));
  }
}

}  // namespace pusht
