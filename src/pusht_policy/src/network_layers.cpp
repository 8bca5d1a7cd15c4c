// SPDX-License-Identifier: BSD-3-Clause
#include "network_layers.hpp"

#include <algorithm>
#include <numeric>
#include <string>

namespace pusht {

using Kind = Operation::Kind;

NetworkTensor NetworkLayers::negative(const NetworkTensor& x) { return network_.combine(Kind::kMultiply, x, -1.0F); }

NetworkTensor NetworkLayers::absolute(const NetworkTensor& x) { return network_.combine(Kind::kMax, x, negative(x)); }

NetworkTensor NetworkLayers::clamp(const NetworkTensor& x, float low, float high) {
  return network_.combine(Kind::kMin, network_.combine(Kind::kMax, x, low), high);
}

NetworkTensor NetworkLayers::power(const NetworkTensor& x, double exponent) {
  constexpr double kRoot = 0.5;
  if (exponent == kRoot) {
    return network_.apply(Kind::kSqrt, x);
  }
  if (exponent == 1.0) {
    return x;
  }
  if (exponent == 2.0) {
    return square(x);
  }
  if (exponent == 3.0) {
    return network_.combine(Kind::kMultiply, x, square(x));
  }
  throw UnfitOperand("its exponent must be 0.5, 1, 2 or 3, not " + std::to_string(exponent));
}

NetworkTensor NetworkLayers::elu(const NetworkTensor& x, float alpha, float gain, float rate) {
  NetworkTensor negative_part = network_.combine(Kind::kMin, x, 0.0F);
  if (rate != 1.0F) {
    negative_part = network_.combine(Kind::kMultiply, negative_part, rate);
  }
  negative_part = network_.apply(Kind::kExpMinusOne, negative_part);
  if (alpha != 1.0F) {
    negative_part = network_.combine(Kind::kMultiply, negative_part, alpha);
  }
  const NetworkTensor sum = network_.combine(Kind::kAdd, negative_part, network_.combine(Kind::kMax, x, 0.0F));
  return gain == 1.0F ? sum : network_.combine(Kind::kMultiply, sum, gain);
}

NetworkTensor NetworkLayers::selu(const NetworkTensor& x) {
  constexpr float kAlpha = 1.67326319217681884765625F;  // of Klambauer et al. 2017, as ONNX has them
  constexpr float kGain = 1.05070102214813232421875F;
  return elu(x, kAlpha, kGain);
}

NetworkTensor NetworkLayers::gelu(const NetworkTensor& x) {
  constexpr float kSqrt2 = 1.4142135623730951F;
  const NetworkTensor erf = network_.apply(Kind::kErf, network_.combine(Kind::kDivide, x, kSqrt2));
  const NetworkTensor doubled = network_.combine(Kind::kMultiply, x, network_.combine(Kind::kAdd, erf, 1.0F));
  return network_.combine(Kind::kMultiply, doubled, 0.5F);
}

NetworkTensor NetworkLayers::geluByTanh(const NetworkTensor& x) {
  constexpr float kSqrt2PerPi = 0.7978845608028654F;
  constexpr float kCubic = 0.044715F;
  const NetworkTensor cubic = network_.combine(Kind::kMultiply, power(x, 3.0), kCubic);
  const NetworkTensor inner = network_.combine(Kind::kMultiply, network_.combine(Kind::kAdd, x, cubic), kSqrt2PerPi);
  const NetworkTensor outer = network_.combine(Kind::kAdd, network_.apply(Kind::kTanh, inner), 1.0F);
  return network_.combine(Kind::kMultiply, network_.combine(Kind::kMultiply, x, 0.5F), outer);
}

NetworkTensor NetworkLayers::silu(const NetworkTensor& x) {
  return network_.combine(Kind::kMultiply, x, network_.apply(Kind::kSigmoid, x));
}

NetworkTensor NetworkLayers::mish(const NetworkTensor& x) {
  return network_.combine(Kind::kMultiply, x, network_.apply(Kind::kTanh, softplus(x, 1.0F)));
}

NetworkTensor NetworkLayers::softplus(const NetworkTensor& x, float beta) {
  if (beta == 1.0F) {
    return network_.apply(Kind::kSoftplus, x);
  }
  const NetworkTensor scaled = network_.combine(Kind::kMultiply, x, beta);
  return network_.combine(Kind::kDivide, network_.apply(Kind::kSoftplus, scaled), beta);
}

NetworkTensor NetworkLayers::leakyRelu(const NetworkTensor& x, const NetworkTensor& slope) {
  const NetworkTensor leak = network_.combine(Kind::kMultiply, network_.combine(Kind::kMin, x, 0.0F), slope);
  return network_.combine(Kind::kAdd, leak, network_.combine(Kind::kMax, x, 0.0F));
}

NetworkTensor NetworkLayers::hardSigmoid(const NetworkTensor& x, float alpha, float beta) {
  return clamp(network_.combine(Kind::kAdd, network_.combine(Kind::kMultiply, x, alpha), beta), 0.0F, 1.0F);
}

NetworkTensor NetworkLayers::hardSwish(const NetworkTensor& x) {
  return network_.combine(Kind::kMultiply, x, hardSigmoid(x));
}

NetworkTensor NetworkLayers::mean(const NetworkTensor& x, const std::vector<std::int64_t>& axes) {
  const NetworkTensor sum = network_.sum(x, axes);
  const int count = columnsOf(x.shape) / columnsOf(sum.shape);
  return network_.combine(Kind::kDivide, sum, static_cast<float>(count));
}

NetworkTensor NetworkLayers::layerNorm(const NetworkTensor& x, const std::vector<std::int64_t>& axes, float epsilon,
                                       const NetworkTensor* scale, const NetworkTensor* shift) {
  const NetworkTensor centered = network_.combine(Kind::kSubtract, x, mean(x, axes));
  const NetworkTensor variance = network_.combine(Kind::kAdd, mean(square(centered), axes), epsilon);
  NetworkTensor y = network_.combine(Kind::kDivide, centered, network_.apply(Kind::kSqrt, variance));
  if (scale != nullptr) {
    y = network_.combine(Kind::kMultiply, y, *scale);
  }
  return shift == nullptr ? y : network_.combine(Kind::kAdd, y, *shift);
}

NetworkTensor NetworkLayers::batchNorm(const NetworkTensor& x, const NetworkTensor& mean, const NetworkTensor& variance,
                                       float epsilon, const NetworkTensor* scale, const NetworkTensor* shift) {
  Sizes shape(x.shape.size(), 1);
  shape.at(1) = x.shape.at(1);
  const auto along_axis = [&](const NetworkTensor& tensor) { return network_.reshape(tensor, shape); };
  const NetworkTensor deviation =
      network_.apply(Kind::kSqrt, network_.combine(Kind::kAdd, along_axis(variance), epsilon));
  NetworkTensor y = network_.combine(Kind::kDivide, network_.combine(Kind::kSubtract, x, along_axis(mean)), deviation);
  if (scale != nullptr) {
    y = network_.combine(Kind::kMultiply, y, along_axis(*scale));
  }
  return shift == nullptr ? y : network_.combine(Kind::kAdd, y, along_axis(*shift));
}

NetworkTensor NetworkLayers::at(const NetworkTensor& x, std::size_t axis, std::int64_t index) {
  const std::int64_t size = x.shape.at(axis);
  if (index < -size || index >= size) {
    throw UnfitOperand("its index must be of one of " + std::to_string(size) + ", not " + std::to_string(index));
  }
  Selection one = sliced(allOf(x.shape), axis, index < 0 ? index + size : index, 1, 1);
  one.shape.erase(one.shape.begin() + static_cast<std::ptrdiff_t>(axis));
  return network_.select({x}, one);
}

std::vector<NetworkTensor> NetworkLayers::split(const NetworkTensor& x, std::size_t axis, const Sizes& sizes) {
  const bool fits = std::all_of(sizes.begin(), sizes.end(), [](std::int64_t size) { return size >= 0; }) &&
                    std::accumulate(sizes.begin(), sizes.end(), std::int64_t{0}) == x.shape.at(axis);
  if (!fits) {
    throw UnfitOperand("its parts must have the " + std::to_string(x.shape.at(axis)) + " numbers of the axis");
  }
  std::vector<NetworkTensor> parts;
  std::int64_t first = 0;
  for (const std::int64_t size : sizes) {
    parts.push_back(network_.select({x}, sliced(allOf(x.shape), axis, first, 1, size)));
    first += size;
  }
  return parts;
}

NetworkTensor NetworkLayers::weighed(const NetworkTensor& rows, const FloatTensor& matrix,
                                     const std::optional<FloatTensor>& bias) {
  const NetworkTensor product = network_.multiplyMatrix(rows, matrix);
  return bias ? network_.combine(Kind::kAdd, product, NetworkBuilder::constant(*bias)) : product;
}

NetworkLayers::States NetworkLayers::cell(const NetworkTensor& input, const States& states,
                                          const CellWeights& weights) {
  const NetworkTensor of_input = weighed(input, weights.of_input, weights.input_bias);
  const NetworkTensor of_state = weighed(states.at(0), weights.of_state, weights.state_bias);
  return states.size() == 1 ? gru(of_input, of_state, states[0]) : lstm(of_input, of_state, states.at(1));
}

NetworkLayers::States NetworkLayers::gru(const NetworkTensor& of_input, const NetworkTensor& of_state,
                                         const NetworkTensor& state) {
  const Sizes gates(3, state.shape.back());
  const std::size_t axis = axisOf(-1, of_input.shape.size());
  const States x = split(of_input, axis, gates);
  const States h = split(of_state, axis, gates);
  const NetworkTensor reset = network_.apply(Kind::kSigmoid, network_.combine(Kind::kAdd, x[0], h[0]));
  const NetworkTensor update = network_.apply(Kind::kSigmoid, network_.combine(Kind::kAdd, x[1], h[1]));
  const NetworkTensor remembered = network_.combine(Kind::kMultiply, reset, h[2]);
  const NetworkTensor fresh = network_.apply(Kind::kTanh, network_.combine(Kind::kAdd, x[2], remembered));
  const NetworkTensor change = network_.combine(Kind::kSubtract, state, fresh);
  return {network_.combine(Kind::kAdd, fresh, network_.combine(Kind::kMultiply, update, change))};
}

NetworkLayers::States NetworkLayers::lstm(const NetworkTensor& of_input, const NetworkTensor& of_state,
                                          const NetworkTensor& cell) {
  const NetworkTensor sum = network_.combine(Kind::kAdd, of_input, of_state);
  const States gates = split(sum, axisOf(-1, sum.shape.size()), Sizes(4, cell.shape.back()));
  const NetworkTensor taken = network_.apply(Kind::kSigmoid, gates[0]);
  const NetworkTensor kept = network_.apply(Kind::kSigmoid, gates[1]);
  const NetworkTensor fresh = network_.apply(Kind::kTanh, gates[2]);
  const NetworkTensor shown = network_.apply(Kind::kSigmoid, gates[3]);
  const NetworkTensor old = network_.combine(Kind::kMultiply, kept, cell);
  const NetworkTensor next = network_.combine(Kind::kAdd, old, network_.combine(Kind::kMultiply, taken, fresh));
  return {network_.combine(Kind::kMultiply, shown, network_.apply(Kind::kTanh, next)), next};
}

NetworkLayers::Unrolled NetworkLayers::unroll(const NetworkTensor& sequence, std::size_t time_axis, States states,
                                              const CellWeights& weights) {
  std::vector<NetworkTensor> outputs;
  for (std::int64_t time = 0; time < sequence.shape.at(time_axis); ++time) {
    states = cell(at(sequence, time_axis, time), states, weights);
    Sizes shape = states[0].shape;
    shape.insert(shape.begin() + static_cast<std::ptrdiff_t>(time_axis), 1);
    outputs.push_back(network_.reshape(states[0], shape));
  }
  return {network_.concatenate(outputs, static_cast<std::int64_t>(time_axis)), states};
}

}  // namespace pusht
