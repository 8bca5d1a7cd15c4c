// SPDX-License-Identifier: BSD-3-Clause
/// Layers that are made of several operations, in the order in which torch's exporter of ONNX writes them, so that both
/// formats of a network have the same bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "network_builder.hpp"

namespace pusht {

/// Layers of a network under construction.
class NetworkLayers {
 public:
  explicit NetworkLayers(NetworkBuilder& network) : network_(network) {}

  NetworkTensor negative(const NetworkTensor& x);
  NetworkTensor absolute(const NetworkTensor& x);
  NetworkTensor clamp(const NetworkTensor& x, float low, float high);
  NetworkTensor square(const NetworkTensor& x) { return network_.combine(Operation::Kind::kMultiply, x, x); }
  /// x to an exponent of 0.5, 1, 2 or 3. Throws UnfitOperand for another.
  NetworkTensor power(const NetworkTensor& x, double exponent);

  /// gain * (x, or alpha * (e^(x * rate) - 1) where x is negative).
  NetworkTensor elu(const NetworkTensor& x, float alpha, float gain = 1.0F, float rate = 1.0F);
  NetworkTensor selu(const NetworkTensor& x);
  NetworkTensor gelu(const NetworkTensor& x);
  NetworkTensor geluByTanh(const NetworkTensor& x);
  NetworkTensor silu(const NetworkTensor& x);
  NetworkTensor mish(const NetworkTensor& x);
  /// log(1 + e^(x * beta)) / beta.
  NetworkTensor softplus(const NetworkTensor& x, float beta);
  NetworkTensor leakyRelu(const NetworkTensor& x, const NetworkTensor& slope);
  /// x * alpha + beta, from 0 to 1.
  NetworkTensor hardSigmoid(const NetworkTensor& x, float alpha = 1.0F / 6.0F, float beta = 0.5F);
  NetworkTensor hardSwish(const NetworkTensor& x);

  NetworkTensor mean(const NetworkTensor& x, const std::vector<std::int64_t>& axes);
  /// Scale and shift may be null.
  NetworkTensor layerNorm(const NetworkTensor& x, const std::vector<std::int64_t>& axes, float epsilon,
                          const NetworkTensor* scale, const NetworkTensor* shift);
  /// With the statistics of training, along axis 1.
  NetworkTensor batchNorm(const NetworkTensor& x, const NetworkTensor& mean, const NetworkTensor& variance,
                          float epsilon, const NetworkTensor* scale, const NetworkTensor* shift);

  /// Weights of a recurrent cell, with its gates side by side: of a GRU reset, update and new; of an LSTM input,
  /// forget, cell and output, as torch has them.
  struct CellWeights {
    FloatTensor of_input;  ///< [inputs, gates * hidden]
    FloatTensor of_state;  ///< [hidden, gates * hidden]
    std::optional<FloatTensor> input_bias{};
    std::optional<FloatTensor> state_bias{};
  };
  using States = std::vector<NetworkTensor>;  ///< of a GRU [n, hidden]; of an LSTM hidden and cell state

  /// Next states of a cell, the hidden one first.
  States cell(const NetworkTensor& input, const States& states, const CellWeights& weights);

  struct Unrolled {
    NetworkTensor outputs;  ///< hidden states of all times
    States states;          ///< after the last
  };
  /// A cell over the times of a sequence, which are along an axis.
  Unrolled unroll(const NetworkTensor& sequence, std::size_t time_axis, States states, const CellWeights& weights);

  /// The tensor at an index of an axis, without that axis.
  NetworkTensor at(const NetworkTensor& x, std::size_t axis, std::int64_t index);
  /// Parts of an axis with these sizes.
  std::vector<NetworkTensor> split(const NetworkTensor& x, std::size_t axis, const Sizes& sizes);

 private:
  NetworkTensor weighed(const NetworkTensor& rows, const FloatTensor& matrix, const std::optional<FloatTensor>& bias);
  States gru(const NetworkTensor& of_input, const NetworkTensor& of_state, const NetworkTensor& state);
  States lstm(const NetworkTensor& of_input, const NetworkTensor& of_state, const NetworkTensor& cell);

  NetworkBuilder& network_;
};

}  // namespace pusht
