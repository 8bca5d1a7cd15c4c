// SPDX-License-Identifier: BSD-3-Clause
// Operators of ONNX that compute numbers.
#include <onnx/onnx_pb.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "onnx_reader.hpp"

namespace pusht {

using Kind = Operation::Kind;

template <Kind kKind>
OnnxReader::Values OnnxReader::readCombination(const Node& node) {
  if (value(node, 0).other != nullptr && value(node, 1).other != nullptr) {
    return combineNumbers(node, kKind);
  }
  const NetworkTensor& left = tensor(node, 0);
  return one(network_.combine(kKind, left, tensor(node, 1)));
}

const std::map<std::string, OnnxReader::Operator>& OnnxReader::operators() {
  using Self = OnnxReader;
  using Layers = NetworkLayers;
  constexpr int kMany = 64;
  static const std::map<std::string, Operator> table = {
      {"Abs", {&Self::readLayer<&Layers::absolute>, 1, 1, {}}},
      {"Add", {&Self::readCombination<Kind::kAdd>, 2, 2, {}}},
      {"BatchNormalization", {&Self::readBatchNormalization, 5, 5, {"epsilon", "momentum", "training_mode"}}},
      {"Cast", {&Self::readCast, 1, 1, {"to", "saturate"}}},
      {"Celu", {&Self::readCelu, 1, 1, {"alpha"}}},
      {"Clip", {&Self::readClip, 1, 3, {"min", "max"}}},
      {"Concat", {&Self::readConcat, 1, kMany, {"axis"}}},
      {"Constant",
       {&Self::readConstant,
        0,
        0,
        {"value", "value_float", "value_floats", "value_int", "value_ints", "value_string", "value_strings",
         "sparse_value"}}},
      {"ConstantOfShape", {&Self::readConstantOfShape, 1, 1, {"value"}}},
      {"Div", {&Self::readCombination<Kind::kDivide>, 2, 2, {}}},
      {"Dropout", {&Self::readDropout, 1, 3, {"ratio", "seed"}}},
      {"Elu", {&Self::readElu, 1, 1, {"alpha"}}},
      {"Erf", {&Self::readFunction<Kind::kErf>, 1, 1, {}}},
      {"Exp", {&Self::readFunction<Kind::kExp>, 1, 1, {}}},
      {"Expand", {&Self::readExpand, 2, 2, {}}},
      {"Flatten", {&Self::readFlatten, 1, 1, {"axis"}}},
      {"GRU",
       {&Self::readRecurrent, 3, 6, {"hidden_size", "direction", "linear_before_reset", "layout", "activations"}}},
      {"Gather", {&Self::readGather, 2, 2, {"axis"}}},
      {"Gelu", {&Self::readGelu, 1, 1, {"approximate"}}},
      {"Gemm", {&Self::readGemm, 2, 3, {"alpha", "beta", "transA", "transB"}}},
      {"HardSigmoid", {&Self::readHardSigmoid, 1, 1, {"alpha", "beta"}}},
      {"HardSwish", {&Self::readLayer<&Layers::hardSwish>, 1, 1, {}}},
      {"Identity", {&Self::readIdentity, 1, 1, {}}},
      {"LSTM", {&Self::readRecurrent, 3, 7, {"hidden_size", "direction", "layout", "activations", "input_forget"}}},
      {"LayerNormalization", {&Self::readLayerNormalization, 2, 3, {"axis", "epsilon", "stash_type"}}},
      {"LeakyRelu", {&Self::readLeakyRelu, 1, 1, {"alpha"}}},
      {"Log", {&Self::readFunction<Kind::kLog>, 1, 1, {}}},
      {"MatMul", {&Self::readMatMul, 2, 2, {}}},
      {"Max", {&Self::readCombination<Kind::kMax>, 2, 2, {}}},
      {"Min", {&Self::readCombination<Kind::kMin>, 2, 2, {}}},
      {"Mish", {&Self::readLayer<&Layers::mish>, 1, 1, {}}},
      {"Mul", {&Self::readCombination<Kind::kMultiply>, 2, 2, {}}},
      {"Neg", {&Self::readLayer<&Layers::negative>, 1, 1, {}}},
      {"PRelu", {&Self::readPRelu, 2, 2, {}}},
      {"Pow", {&Self::readPow, 2, 2, {}}},
      {"Reciprocal", {&Self::readReciprocal, 1, 1, {}}},
      {"ReduceMean", {&Self::readReduceMean, 1, 2, {"axes", "keepdims", "noop_with_empty_axes"}}},
      {"ReduceSum", {&Self::readReduceSum, 1, 2, {"axes", "keepdims", "noop_with_empty_axes"}}},
      {"Relu", {&Self::readRelu, 1, 1, {}}},
      {"Reshape", {&Self::readReshape, 2, 2, {"allowzero"}}},
      {"Selu", {&Self::readSelu, 1, 1, {"alpha", "gamma"}}},
      {"Shape", {&Self::readShape, 1, 1, {"start", "end"}}},
      {"Sigmoid", {&Self::readFunction<Kind::kSigmoid>, 1, 1, {}}},
      {"Slice", {&Self::readSlice, 1, 5, {"axes", "starts", "ends"}}},
      {"Softplus", {&Self::readFunction<Kind::kSoftplus>, 1, 1, {}}},
      {"Softsign", {&Self::readSoftsign, 1, 1, {}}},
      {"Split", {&Self::readSplit, 1, 2, {"axis", "split", "num_outputs"}}},
      {"Sqrt", {&Self::readFunction<Kind::kSqrt>, 1, 1, {}}},
      {"Squeeze", {&Self::readSqueeze, 1, 2, {"axes"}}},
      {"Sub", {&Self::readCombination<Kind::kSubtract>, 2, 2, {}}},
      {"Tanh", {&Self::readFunction<Kind::kTanh>, 1, 1, {}}},
      {"Transpose", {&Self::readTranspose, 1, 1, {"perm"}}},
      {"Unsqueeze", {&Self::readUnsqueeze, 1, 2, {"axes"}}},
  };
  return table;
}

/// Integers of shapes: of equal count, or one of them a single number.
OnnxReader::Values OnnxReader::combineNumbers(const Node& node, Kind kind) {
  const OnnxConstant& left = *value(node, 0).other;
  const OnnxConstant& right = *value(node, 1).other;
  const std::size_t count = std::max(left.numbers.size(), right.numbers.size());
  const auto fits = [&](const OnnxConstant& side) { return side.numbers.size() == count || side.numbers.size() == 1; };
  if (!fits(left) || !fits(right)) {
    throw UnfitForKernel("its constants must have the same shape, or one of them one number");
  }
  OnnxConstant result = left.numbers.size() == count ? left : right;
  for (std::size_t i = 0; i < count; ++i) {
    const double a = left.numbers[left.numbers.size() == 1 ? 0 : i];
    const double b = right.numbers[right.numbers.size() == 1 ? 0 : i];
    const std::map<Kind, double> results = {
        {Kind::kAdd, a + b},          {Kind::kSubtract, a - b},
        {Kind::kMultiply, a * b},     {Kind::kDivide, b == 0.0 ? 0.0 : std::trunc(a / b)},
        {Kind::kMax, std::max(a, b)}, {Kind::kMin, std::min(a, b)}};
    result.numbers[i] = results.at(kind);
  }
  return {number(std::move(result))};
}

OnnxReader::Values OnnxReader::readGemm(const Node& node) {
  if (integerOf(node, "transA", 0) != 0) {
    throw UnfitForKernel("its transA must be 0");
  }
  const NetworkTensor& rows = tensor(node, 0);
  const FloatTensor& matrix = constant(node, 1);
  NetworkTensor result = network_.multiplyMatrix(rows, integerOf(node, "transB", 0) != 0 ? transposed(matrix) : matrix);
  if (const float alpha = floatOf(node, "alpha", 1.0F); alpha != 1.0F) {
    result = network_.combine(Kind::kMultiply, result, alpha);
  }
  if (has(node, 2)) {
    const float beta = floatOf(node, "beta", 1.0F);
    const NetworkTensor& bias = tensor(node, 2);
    result = network_.combine(Kind::kAdd, result, beta == 1.0F ? bias : network_.combine(Kind::kMultiply, bias, beta));
  }
  return one(result);
}

OnnxReader::Values OnnxReader::readMatMul(const Node& node) {
  const NetworkTensor& rows = tensor(node, 0);
  return one(network_.multiplyMatrix(rows, constant(node, 1)));
}

OnnxReader::Values OnnxReader::readPow(const Node& node) {
  const Value& exponent = value(node, 1);
  const std::vector<double> values =
      exponent.other != nullptr ? exponent.other->numbers
                                : std::vector<double>(constant(node, 1).values.begin(), constant(node, 1).values.end());
  if (values.size() != 1) {
    throw UnfitForKernel("its exponent must be one number");
  }
  return one(layers_.power(tensor(node, 0), values.front()));
}

OnnxReader::Values OnnxReader::readReciprocal(const Node& node) {
  return one(network_.combine(Kind::kDivide, NetworkBuilder::number(1.0F), tensor(node, 0)));
}

OnnxReader::Values OnnxReader::readRelu(const Node& node) {
  return one(network_.combine(Kind::kMax, tensor(node, 0), 0.0F));
}

/// Bounds are attributes before opset 11, inputs from then on.
OnnxReader::Values OnnxReader::readClip(const Node& node) {
  constexpr std::int64_t kInputsSince = 11;
  if (opset_ < kInputsSince ? node.input_size() > 1 : node.attribute_size() > 0) {
    throw UnfitForKernel("its bounds must be " + std::string(opset_ < kInputsSince ? "attributes" : "inputs") +
                         " in opset " + std::to_string(opset_));
  }
  NetworkTensor result = tensor(node, 0);
  for (const auto& [kind, name, input] : {std::tuple(Kind::kMax, "min", 1), std::tuple(Kind::kMin, "max", 2)}) {
    if (hasAttribute(node, name)) {
      result = network_.combine(kind, result, floatOf(node, name, 0.0F));
    } else if (has(node, input)) {
      result = network_.combine(kind, result, tensor(node, input));
    }
  }
  return one(result);
}

OnnxReader::Values OnnxReader::readElu(const Node& node) {
  return one(layers_.elu(tensor(node, 0), floatOf(node, "alpha", 1.0F)));
}

OnnxReader::Values OnnxReader::readCelu(const Node& node) {
  const float alpha = floatOf(node, "alpha", 1.0F);
  return one(layers_.elu(tensor(node, 0), alpha, 1.0F, 1.0F / alpha));
}

OnnxReader::Values OnnxReader::readSelu(const Node& node) {
  constexpr float kAlpha = 1.67326319217681884765625F;  // ONNX's
  constexpr float kGamma = 1.05070102214813232421875F;
  return one(layers_.elu(tensor(node, 0), floatOf(node, "alpha", kAlpha), floatOf(node, "gamma", kGamma)));
}

OnnxReader::Values OnnxReader::readGelu(const Node& node) {
  const NetworkTensor& x = tensor(node, 0);
  return one(textOf(node, "approximate") == "tanh" ? layers_.geluByTanh(x) : layers_.gelu(x));
}

OnnxReader::Values OnnxReader::readLeakyRelu(const Node& node) {
  constexpr float kAlpha = 0.01F;  // ONNX's
  return one(layers_.leakyRelu(tensor(node, 0), NetworkBuilder::number(floatOf(node, "alpha", kAlpha))));
}

OnnxReader::Values OnnxReader::readPRelu(const Node& node) {
  const NetworkTensor& x = tensor(node, 0);
  return one(layers_.leakyRelu(x, tensor(node, 1)));
}

OnnxReader::Values OnnxReader::readHardSigmoid(const Node& node) {
  constexpr float kAlpha = 0.2F;  // ONNX's
  constexpr float kBeta = 0.5F;
  return one(layers_.hardSigmoid(tensor(node, 0), floatOf(node, "alpha", kAlpha), floatOf(node, "beta", kBeta)));
}

OnnxReader::Values OnnxReader::readSoftsign(const Node& node) {
  const NetworkTensor& x = tensor(node, 0);
  return one(network_.combine(Kind::kDivide, x, network_.combine(Kind::kAdd, layers_.absolute(x), 1.0F)));
}

OnnxReader::Values OnnxReader::readReduceMean(const Node& node) {
  constexpr std::int64_t kAxesAreInputsSince = 18;
  return reduced(node, kAxesAreInputsSince, true);
}

OnnxReader::Values OnnxReader::readReduceSum(const Node& node) {
  constexpr std::int64_t kAxesAreInputsSince = 13;
  return reduced(node, kAxesAreInputsSince, false);
}

OnnxReader::Values OnnxReader::reduced(const Node& node, std::int64_t axes_are_inputs_since, bool mean) {
  const NetworkTensor& x = tensor(node, 0);
  const Sizes axes = axesOf(node, axes_are_inputs_since, value(node, 0));
  if (axes.empty() || (x.shape[0] == 1 && std::count(axes.begin(), axes.end(), 0) > 0)) {
    throw UnfitForKernel("its axes must be named, and not be the first, that of rollouts");
  }
  const NetworkTensor result = mean ? layers_.mean(x, axes) : network_.sum(x, axes);
  Sizes shape;
  for (std::size_t axis = 0; axis < result.shape.size(); ++axis) {
    const bool goes = integerOf(node, "keepdims", 1) == 0 &&
                      std::count(axes.begin(), axes.end(), static_cast<std::int64_t>(axis)) > 0;
    if (!goes) {
      shape.push_back(result.shape[axis]);
    }
  }
  return one(network_.reshape(result, shape));
}

OnnxReader::Values OnnxReader::readLayerNormalization(const Node& node) {
  constexpr float kEpsilon = 1e-5F;  // ONNX's
  const NetworkTensor& x = tensor(node, 0);
  std::vector<std::int64_t> axes;
  for (std::size_t axis = axisOf(integerOf(node, "axis", -1), x.shape.size()); axis < x.shape.size(); ++axis) {
    axes.push_back(static_cast<std::int64_t>(axis));
  }
  const NetworkTensor& scale = tensor(node, 1);
  return one(layers_.layerNorm(x, axes, floatOf(node, "epsilon", kEpsilon), &scale,
                               has(node, 2) ? &tensor(node, 2) : nullptr));
}

OnnxReader::Values OnnxReader::readBatchNormalization(const Node& node) {
  constexpr float kEpsilon = 1e-5F;  // ONNX's
  constexpr int kMean = 3;
  constexpr int kVariance = 4;
  if (integerOf(node, "training_mode", 0) != 0 || node.output_size() > 1) {
    throw UnfitForKernel("must be in evaluation: call .eval() before exporting");
  }
  const NetworkTensor& x = tensor(node, 0);
  return one(layers_.batchNorm(x, tensor(node, kMean), tensor(node, kVariance), floatOf(node, "epsilon", kEpsilon),
                               &tensor(node, 1), &tensor(node, 2)));
}

/// Parts of the first axis in another order.
NetworkTensor OnnxReader::reordered(const NetworkTensor& gates, const std::vector<std::size_t>& order) {
  const auto count = static_cast<std::int64_t>(order.size());
  const std::vector<NetworkTensor> parts = layers_.split(gates, 0, Sizes(order.size(), gates.shape.at(0) / count));
  std::vector<NetworkTensor> sorted;
  sorted.reserve(order.size());
  for (const std::size_t index : order) {
    sorted.push_back(parts.at(index));
  }
  return network_.concatenate(sorted, 0);
}

/// Weights of the only direction, with gates in the order of the kernel's cells.
NetworkLayers::CellWeights OnnxReader::cellWeights(const Node& node, const std::vector<std::size_t>& order) {
  constexpr int kBiases = 3;
  const auto matrix = [&](int input) {
    const NetworkTensor gates = layers_.at(NetworkBuilder::constant(constant(node, input)), 0, 0);
    return transposed(*reordered(gates, order).constant);
  };
  NetworkLayers::CellWeights weights{matrix(1), matrix(2)};
  if (has(node, kBiases)) {
    const NetworkTensor biases = layers_.at(NetworkBuilder::constant(constant(node, kBiases)), 0, 0);
    const std::int64_t half = biases.shape.at(0) / 2;
    const std::vector<NetworkTensor> halves = layers_.split(biases, 0, {half, half});
    weights.input_bias = *reordered(halves[0], order).constant;
    weights.state_bias = *reordered(halves[1], order).constant;
  }
  return weights;
}

/// GRU or LSTM of one direction, [time, n, inputs].
OnnxReader::Values OnnxReader::readRecurrent(const Node& node) {
  constexpr int kLengths = 4;
  constexpr int kFirstState = 5;
  const bool is_lstm = node.op_type() == "LSTM";
  const std::string direction = textOf(node, "direction");
  if ((!direction.empty() && direction != "forward") || integerOf(node, "layout", 0) != 0 ||
      hasAttribute(node, "activations") || has(node, kLengths) || integerOf(node, "input_forget", 0) != 0) {
    throw UnfitForKernel("must have one direction, layout 0, its own activations and no lengths");
  }
  if (!is_lstm && integerOf(node, "linear_before_reset", 0) != 1) {
    throw UnfitForKernel("its linear_before_reset must be 1, as in torch");
  }
  const NetworkTensor& sequence = tensor(node, 0);
  const FloatTensor& of_state = constant(node, 2);
  if (sequence.shape.size() != 3 || of_state.shape.size() != 3 || of_state.shape[0] != 1) {
    throw UnfitForKernel("must take a sequence [time, n, inputs], and weights of one direction");
  }
  const std::int64_t hidden = of_state.shape[2];
  NetworkLayers::States states;
  for (int i = 0; i < (is_lstm ? 2 : 1); ++i) {
    const Sizes shape = {1, hidden};
    states.push_back(has(node, kFirstState + i)
                         ? layers_.at(tensor(node, kFirstState + i), 0, 0)
                         : NetworkBuilder::constant({shape, std::vector<float>(columnsOf(shape))}));
  }
  const std::vector<std::size_t> order =
      is_lstm ? std::vector<std::size_t>{0, 2, 3, 1} : std::vector<std::size_t>{1, 0, 2};
  const NetworkLayers::Unrolled unrolled = layers_.unroll(sequence, 0, states, cellWeights(node, order));
  Values results = one(network_.reshape(unrolled.outputs, {sequence.shape[0], 1, 1, hidden}));
  for (const NetworkTensor& state : unrolled.states) {
    results.push_back({network_.reshape(state, {1, 1, hidden})});
  }
  return results;
}

}  // namespace pusht
