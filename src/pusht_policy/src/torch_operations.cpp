// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <utility>

#include "torch_network.hpp"
#include "torch_reader.hpp"

namespace pusht {

using Kind = Operation::Kind;

const std::map<std::string, TorchReader::Reader>& TorchReader::readers() {
  using Self = TorchReader;
  using Layers = NetworkLayers;
  static const std::map<std::string, Reader> table = {
      {"aten::linear", &Self::readLinear},
      {"aten::addmm", &Self::readAddmm},
      {"aten::matmul", &Self::readMatmul},
      {"aten::mm", &Self::readMatmul},
      {"aten::add", &Self::readAdd},
      {"aten::sub", &Self::readSub},
      {"aten::rsub", &Self::readRsub},
      {"aten::mul", &Self::readCombination<Kind::kMultiply>},
      {"aten::div", &Self::readDiv},
      {"aten::maximum", &Self::readCombination<Kind::kMax>},
      {"aten::minimum", &Self::readCombination<Kind::kMin>},
      {"aten::reciprocal", &Self::readReciprocal},
      {"aten::rsqrt", &Self::readRsqrt},
      {"aten::pow", &Self::readPow},
      {"aten::neg", &Self::readLayer<&Layers::negative>},
      {"aten::abs", &Self::readLayer<&Layers::absolute>},
      {"aten::square", &Self::readLayer<&Layers::square>},
      {"aten::relu", &Self::readRelu},
      {"aten::relu6", &Self::readRelu6},
      {"aten::clamp", &Self::readClamp},
      {"aten::clamp_min", &Self::readClamp},
      {"aten::clamp_max", &Self::readClamp},
      {"aten::hardtanh", &Self::readHardtanh},
      {"aten::tanh", &Self::readFunction<Kind::kTanh>},
      {"aten::erf", &Self::readFunction<Kind::kErf>},
      {"aten::exp", &Self::readFunction<Kind::kExp>},
      {"aten::expm1", &Self::readFunction<Kind::kExpMinusOne>},
      {"aten::log", &Self::readFunction<Kind::kLog>},
      {"aten::sqrt", &Self::readFunction<Kind::kSqrt>},
      {"aten::sigmoid", &Self::readFunction<Kind::kSigmoid>},
      {"aten::elu", &Self::readElu},
      {"aten::celu", &Self::readCelu},
      {"aten::selu", &Self::readLayer<&Layers::selu>},
      {"aten::gelu", &Self::readGelu},
      {"aten::glu", &Self::readGlu},
      {"aten::silu", &Self::readLayer<&Layers::silu>},
      {"aten::mish", &Self::readLayer<&Layers::mish>},
      {"aten::leaky_relu", &Self::readLeakyRelu},
      {"aten::prelu", &Self::readPrelu},
      {"aten::softplus", &Self::readSoftplus},
      {"aten::log_sigmoid", &Self::readLogSigmoid},
      {"aten::hardsigmoid", &Self::readHardSigmoid},
      {"aten::hardswish", &Self::readLayer<&Layers::hardSwish>},
      {"aten::mean", &Self::readMean},
      {"aten::sum", &Self::readSum},
      {"aten::layer_norm", &Self::readLayerNorm},
      {"aten::batch_norm", &Self::readBatchNorm},
      {"aten::to", &Self::readTo},
      {"aten::dropout", &Self::readDropout},
      {"aten::feature_dropout", &Self::readDropout},
      {"aten::alpha_dropout", &Self::readDropout},
      {"aten::detach", &Self::readCopy},
      {"aten::contiguous", &Self::readCopy},
      {"aten::clone", &Self::readCopy},
      {"aten::zeros", &Self::readFilled},
      {"aten::ones", &Self::readFilled},
      {"aten::full", &Self::readFilled},
      {"aten::full_like", &Self::readFilled},
      {"aten::zeros_like", &Self::readFilled},
      {"aten::ones_like", &Self::readFilled},
      {"aten::flatten", &Self::readFlatten},
      {"aten::reshape", &Self::readReshape},
      {"aten::view", &Self::readReshape},
      {"aten::unflatten", &Self::readUnflatten},
      {"aten::unsqueeze", &Self::readUnsqueeze},
      {"aten::squeeze", &Self::readSqueeze},
      {"aten::slice", &Self::readSlice},
      {"aten::narrow", &Self::readNarrow},
      {"aten::index", &Self::readIndex},
      {"aten::index_select", &Self::readIndexSelect},
      {"aten::select", &Self::readSelect},
      {"aten::transpose", &Self::readTranspose},
      {"aten::t", &Self::readMatrixTranspose},
      {"aten::permute", &Self::readPermute},
      {"aten::expand", &Self::readExpand},
      {"aten::expand_as", &Self::readExpandAs},
      {"aten::repeat", &Self::readRepeat},
      {"aten::cat", &Self::readCat},
      {"aten::stack", &Self::readStack},
      {"aten::gru_cell", &Self::readGruCell},
  };
  return table;
}

/// Operations whose results may lie in the memory of what they take.
const std::set<std::string>& TorchReader::views() {
  static const std::set<std::string> names = {
      "aten::to",     "aten::detach",  "aten::contiguous", "aten::flatten",   "aten::reshape", "aten::view",
      "aten::slice",  "aten::squeeze", "aten::unflatten",  "aten::unsqueeze", "aten::narrow",  "aten::select",
      "aten::expand", "aten::permute", "aten::transpose",  "aten::expand_as", "aten::t",       "aten::dropout"};
  return names;
}

NetworkTensor TorchReader::readLinear(const Node& node) {
  const IValue weight = constant(node, "weight");
  const FloatTensor matrix = this->matrix(weight.isTensor() ? weight.toTensor().t() : weight);
  const NetworkTensor product = network_.multiplyMatrix(tensor(node, "input"), matrix);
  return hasOperand(node, "bias") ? network_.combine(Kind::kAdd, product, operand(node, "bias")) : product;
}

NetworkTensor TorchReader::readAddmm(const Node& node) {
  requireOne(node, "beta");
  requireOne(node, "alpha");
  const NetworkTensor product = network_.multiplyMatrix(tensor(node, "mat1"), matrix(constant(node, "mat2")));
  return network_.combine(Kind::kAdd, product, operand(node, "self"));
}

NetworkTensor TorchReader::readMatmul(const Node& node) {
  const char* const other = node.hasNamedInput("mat2") ? "mat2" : "other";
  return network_.multiplyMatrix(tensor(node, "self"), matrix(constant(node, other)));
}

NetworkTensor TorchReader::readAdd(const Node& node) {
  requireOne(node, "alpha");
  return readCombination<Kind::kAdd>(node);
}

NetworkTensor TorchReader::readSub(const Node& node) {
  requireOne(node, "alpha");
  return readCombination<Kind::kSubtract>(node);
}

NetworkTensor TorchReader::readRsub(const Node& node) {
  requireOne(node, "alpha");
  return network_.combine(Kind::kSubtract, operand(node, "other"), tensor(node, "self"));
}

NetworkTensor TorchReader::readDiv(const Node& node) {
  if (node.hasNamedInput("rounding_mode") && !constant(node, "rounding_mode").isNone()) {
    refuse("must not round");
  }
  return readCombination<Kind::kDivide>(node);
}

NetworkTensor TorchReader::readReciprocal(const Node& node) {
  return network_.combine(Kind::kDivide, NetworkBuilder::number(1.0F), tensor(node, "self"));
}

NetworkTensor TorchReader::readRsqrt(const Node& node) {
  return network_.combine(Kind::kDivide, NetworkBuilder::number(1.0F),
                          network_.apply(Kind::kSqrt, tensor(node, "self")));
}

NetworkTensor TorchReader::readPow(const Node& node) {
  const IValue exponent = constant(node, "exponent");
  if (!exponent.isScalar()) {
    refuse("its exponent must be a number");
  }
  return layers_.power(tensor(node, "self"), exponent.toScalar().toDouble());
}

NetworkTensor TorchReader::readRelu(const Node& node) {
  return network_.combine(Kind::kMax, tensor(node, "self"), 0.0F);
}

NetworkTensor TorchReader::readRelu6(const Node& node) { return layers_.clamp(tensor(node, "self"), 0.0F, 6.0F); }

NetworkTensor TorchReader::readClamp(const Node& node) {
  NetworkTensor clamped = tensor(node, "self");
  for (const auto& [input, kind] : {std::pair("min", Kind::kMax), std::pair("max", Kind::kMin)}) {
    if (hasOperand(node, input)) {
      clamped = network_.combine(kind, clamped, operand(node, input));
    }
  }
  return clamped;
}

NetworkTensor TorchReader::readHardtanh(const Node& node) {
  const NetworkTensor raised = network_.combine(Kind::kMax, tensor(node, "self"), operand(node, "min_val"));
  return network_.combine(Kind::kMin, raised, operand(node, "max_val"));
}

NetworkTensor TorchReader::readElu(const Node& node) {
  return layers_.elu(tensor(node, "self"), static_cast<float>(numberOf(node, "alpha")),
                     static_cast<float>(numberOf(node, "scale")), static_cast<float>(numberOf(node, "input_scale")));
}

NetworkTensor TorchReader::readCelu(const Node& node) {
  const auto alpha = static_cast<float>(numberOf(node, "alpha"));
  return layers_.elu(tensor(node, "self"), alpha, 1.0F, 1.0F / alpha);
}

NetworkTensor TorchReader::readGelu(const Node& node) {
  const bool by_tanh = node.hasNamedInput("approximate") && constant(node, "approximate").toStringRef() == "tanh";
  return by_tanh ? layers_.geluByTanh(tensor(node, "self")) : layers_.gelu(tensor(node, "self"));
}

NetworkTensor TorchReader::readLeakyRelu(const Node& node) {
  return layers_.leakyRelu(tensor(node, "self"), operand(node, "negative_slope"));
}

/// A slope for each channel, along axis 1.
NetworkTensor TorchReader::readPrelu(const Node& node) {
  const NetworkTensor x = tensor(node, "self");
  const NetworkTensor slope = operand(node, "weight");
  Sizes shape(x.shape.size(), 1);
  shape.at(std::min<std::size_t>(1, shape.size() - 1)) = columnsOf(slope.shape);
  return layers_.leakyRelu(x, network_.reshape(slope, shape));
}

NetworkTensor TorchReader::readSoftplus(const Node& node) {
  constexpr double kLeast = 15.0;  // from there on, softplus(x) and x are nearer than a float32's last bit
  if (numberOf(node, "threshold") < kLeast) {
    refuse("its threshold must be at least 15");
  }
  return layers_.softplus(tensor(node, "self"), static_cast<float>(numberOf(node, "beta")));
}

NetworkTensor TorchReader::readLogSigmoid(const Node& node) {
  return layers_.negative(layers_.softplus(layers_.negative(tensor(node, "self")), 1.0F));
}

NetworkTensor TorchReader::readHardSigmoid(const Node& node) { return layers_.hardSigmoid(tensor(node, "self")); }

NetworkTensor TorchReader::readMean(const Node& node) {
  const NetworkTensor mean = layers_.mean(tensor(node, "self"), reducedAxes(node));
  return network_.reshape(mean, reducedShape(node));
}

NetworkTensor TorchReader::readSum(const Node& node) {
  const NetworkTensor sum = network_.sum(tensor(node, "self"), reducedAxes(node));
  return network_.reshape(sum, reducedShape(node));
}

/// Axes of a reduction, which must leave the rollouts apart: a first axis of size 1 may be theirs.
std::vector<std::int64_t> TorchReader::reducedAxes(const Node& node) const {
  if (!hasOperand(node, "dim")) {
    refuse("must name its axes");
  }
  std::vector<std::int64_t> axes = this->axes(node, "dim");
  const Sizes shape = tensor(node, "self").shape;
  const auto is_of_rollouts = [&](std::int64_t axis) { return axisOf(axis, shape.size()) == 0 && shape[0] == 1; };
  if (axes.empty() || std::any_of(axes.begin(), axes.end(), is_of_rollouts)) {
    refuse("must not be along the first axis, that of rollouts");
  }
  return axes;
}

Sizes TorchReader::reducedShape(const Node& node) const {
  return torch::empty(tensor(node, "self").shape)
      .sum(axes(node, "dim"), constant(node, "keepdim").toBool())
      .sizes()
      .vec();
}

NetworkTensor TorchReader::readLayerNorm(const Node& node) {
  std::vector<std::int64_t> last(constant(node, "normalized_shape").toIntVector().size());
  for (std::size_t i = 0; i < last.size(); ++i) {
    last[i] = static_cast<std::int64_t>(i) - static_cast<std::int64_t>(last.size());
  }
  const auto scale = optional(node, "weight");
  const auto shift = optional(node, "bias");
  return layers_.layerNorm(tensor(node, "input"), last, static_cast<float>(numberOf(node, "eps")),
                           scale ? &*scale : nullptr, shift ? &*shift : nullptr);
}

NetworkTensor TorchReader::readBatchNorm(const Node& node) {
  if (constant(node, "training").toBool()) {
    refuse("must be in evaluation: call .eval() before tracing");
  }
  const auto scale = optional(node, "weight");
  const auto shift = optional(node, "bias");
  return layers_.batchNorm(tensor(node, "input"), operand(node, "running_mean"), operand(node, "running_var"),
                           static_cast<float>(numberOf(node, "eps")), scale ? &*scale : nullptr,
                           shift ? &*shift : nullptr);
}

std::optional<NetworkTensor> TorchReader::optional(const Node& node, const char* input) const {
  return hasOperand(node, input) ? std::optional<NetworkTensor>(operand(node, input)) : std::nullopt;
}

NetworkTensor TorchReader::readTo(const Node& node) {
  const IValue type = node.hasNamedInput("dtype") ? constant(node, "dtype") : IValue();
  const bool keeps = node.hasNamedInput("other") ? items_.count(node.namedInput("other")) > 0
                                                 : type.isNone() || type.toScalarType() == torch::kFloat32;
  if (!keeps) {
    refuse("must keep float32");
  }
  return tensor(node, "self");
}

NetworkTensor TorchReader::readDropout(const Node& node) {
  if (constant(node, "train").toBool()) {
    refuse("must be off: call .eval() before tracing");
  }
  return tensor(node, "input");
}

/// A constant of zeros, ones or another number, of a shape or of that of a tensor.
NetworkTensor TorchReader::readFilled(const Node& node) {
  const std::string name = node.kind().toQualString();
  const Sizes shape = node.hasNamedInput("size") ? constant(node, "size").toIntVector() : tensor(node, "self").shape;
  double value = name.find("ones") == std::string::npos ? 0.0 : 1.0;
  if (node.hasNamedInput("fill_value")) {
    value = numberOf(node, "fill_value");
  }
  return NetworkBuilder::constant({shape, std::vector<float>(columnsOf(shape), static_cast<float>(value))});
}

NetworkTensor TorchReader::readGlu(const Node& node) {
  const NetworkTensor x = tensor(node, "self");
  const std::size_t axis = axisOf(constant(node, "dim").toInt(), x.shape.size());
  const std::vector<NetworkTensor> halves = layers_.split(x, axis, Sizes(2, x.shape[axis] / 2));
  return network_.combine(Kind::kMultiply, halves[0], network_.apply(Kind::kSigmoid, halves[1]));
}

}  // namespace pusht
