// SPDX-License-Identifier: BSD-3-Clause
// Operations that move numbers: libtorch itself does them to a tensor of the indices of the elements.
#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>

#include "torch_reader.hpp"

namespace pusht {

torch::Tensor TorchReader::indicesOf(const NetworkTensor& tensor) {
  return torch::arange(columnsOf(tensor.shape), torch::kInt32).reshape(tensor.shape);
}

NetworkTensor TorchReader::moved(const NetworkTensor& tensor, const torch::Tensor& indices) {
  const torch::Tensor plain = indices.contiguous();
  return network_.select({tensor},
                         {plain.sizes().vec(), {plain.data_ptr<int>(), plain.data_ptr<int>() + plain.numel()}});
}

NetworkTensor TorchReader::readFlatten(const Node& node) {
  const NetworkTensor x = tensor(node, "self");
  return moved(x, indicesOf(x).flatten(constant(node, "start_dim").toInt(), constant(node, "end_dim").toInt()));
}

NetworkTensor TorchReader::readReshape(const Node& node) {
  const NetworkTensor x = tensor(node, "self");
  return moved(x, indicesOf(x).reshape(constant(node, node.hasNamedInput("shape") ? "shape" : "size").toIntVector()));
}

NetworkTensor TorchReader::readUnflatten(const Node& node) {
  const NetworkTensor x = tensor(node, "self");
  const Sizes parts = constant(node, "sizes").toIntVector();
  const std::size_t axis = axisOf(constant(node, "dim").toInt(), x.shape.size());
  Sizes sizes = x.shape;
  const auto place = sizes.erase(sizes.begin() + static_cast<std::ptrdiff_t>(axis));
  sizes.insert(place, parts.begin(), parts.end());
  return moved(x, indicesOf(x).reshape(sizes));
}

NetworkTensor TorchReader::readUnsqueeze(const Node& node) {
  const NetworkTensor x = tensor(node, "self");
  return moved(x, indicesOf(x).unsqueeze(constant(node, "dim").toInt()));
}

NetworkTensor TorchReader::readSqueeze(const Node& node) {
  const NetworkTensor x = tensor(node, "self");
  const torch::Tensor indices = indicesOf(x);
  return moved(x, node.hasNamedInput("dim") ? indices.squeeze(constant(node, "dim").toInt()) : indices.squeeze());
}

NetworkTensor TorchReader::readSlice(const Node& node) {
  const NetworkTensor x = tensor(node, "self");
  const auto bound = [&](const char* input) {
    const IValue value = constant(node, input);
    return value.isNone() ? c10::optional<std::int64_t>() : c10::optional<std::int64_t>(value.toInt());
  };
  return moved(x, indicesOf(x).slice(constant(node, "dim").toInt(), bound("start"), bound("end"),
                                     constant(node, "step").toInt()));
}

NetworkTensor TorchReader::readNarrow(const Node& node) {
  const NetworkTensor x = tensor(node, "self");
  return moved(x, indicesOf(x).narrow(constant(node, "dim").toInt(), constant(node, "start").toInt(),
                                      constant(node, "length").toInt()));
}

NetworkTensor TorchReader::readSelect(const Node& node) {
  const NetworkTensor x = tensor(node, "self");
  return moved(x, indicesOf(x).select(constant(node, "dim").toInt(), constant(node, "index").toInt()));
}

/// Rows or columns by constant indices: x[:, [6, 7]].
NetworkTensor TorchReader::readIndex(const Node& node) {
  const Value* const list = node.namedInput("indices");
  std::vector<std::optional<IValue>> indices;
  if (const auto known = sizes_.valueOf(list)) {
    indices.assign(known->toListRef().begin(), known->toListRef().end());
  } else {
    for (const Value* index : list->node()->inputs()) {
      indices.push_back(sizes_.valueOf(index));
    }
  }
  c10::List<c10::optional<at::Tensor>> places;
  for (const auto& index : indices) {
    if (!index || !(index->isNone() || index->isTensor())) {
      refuse("its indices must be constant");
    }
    places.push_back(index->isNone() ? c10::optional<at::Tensor>() : index->toTensor());
  }
  const NetworkTensor x = tensor(node, "self");
  return moved(x, at::index(indicesOf(x), places));
}

NetworkTensor TorchReader::readIndexSelect(const Node& node) {
  const NetworkTensor x = tensor(node, "self");
  return moved(x, indicesOf(x).index_select(constant(node, "dim").toInt(), constant(node, "index").toTensor()));
}

NetworkTensor TorchReader::readTranspose(const Node& node) {
  const NetworkTensor x = tensor(node, "self");
  return moved(x, indicesOf(x).transpose(constant(node, "dim0").toInt(), constant(node, "dim1").toInt()));
}

NetworkTensor TorchReader::readMatrixTranspose(const Node& node) {
  const NetworkTensor x = tensor(node, "self");
  return moved(x, indicesOf(x).t());
}

NetworkTensor TorchReader::readPermute(const Node& node) {
  const NetworkTensor x = tensor(node, "self");
  return moved(x, indicesOf(x).permute(constant(node, "dims").toIntVector()));
}

NetworkTensor TorchReader::readExpand(const Node& node) {
  const NetworkTensor x = tensor(node, "self");
  return moved(x, indicesOf(x).expand(constant(node, "size").toIntVector()));
}

NetworkTensor TorchReader::readExpandAs(const Node& node) {
  const NetworkTensor x = tensor(node, "self");
  return moved(x, indicesOf(x).expand(tensor(node, "other").shape));
}

NetworkTensor TorchReader::readRepeat(const Node& node) {
  const NetworkTensor x = tensor(node, "self");
  return moved(x, indicesOf(x).repeat(constant(node, "repeats").toIntVector()));
}

/// Tensors of a list with a tensor in it.
std::vector<NetworkTensor> TorchReader::tensorsIn(const Node& node, const char* input) const {
  const auto found = items_.find(node.namedInput(input));
  if (found == items_.end()) {
    refuse("its operands must be a list of tensors");
  }
  std::vector<NetworkTensor> tensors;
  for (const Item& part : found->second) {
    requireUpToDate(part);
    tensors.push_back(part.tensor);
  }
  return tensors;
}

NetworkTensor TorchReader::readCat(const Node& node) {
  return network_.concatenate(tensorsIn(node, "tensors"), constant(node, "dim").toInt());
}

NetworkTensor TorchReader::readStack(const Node& node) {
  std::vector<NetworkTensor> tensors = tensorsIn(node, "tensors");
  const std::int64_t dim = constant(node, "dim").toInt();
  for (NetworkTensor& part : tensors) {
    part = moved(part, indicesOf(part).unsqueeze(dim));
  }
  return network_.concatenate(tensors, dim);
}

/// Results of operations that have several; empty for others.
TorchReader::Items TorchReader::readParts(const Node& node) {
  constexpr std::string_view kUnsafe = "aten::unsafe_";  // parts that nothing else reads, as gates of a traced cell
  std::string name = node.kind().toQualString();
  const bool is_unsafe = name.rfind(kUnsafe, 0) == 0;
  if (is_unsafe) {
    name.replace(0, kUnsafe.size(), "aten::");
  }
  if (name == "aten::lstm_cell") {
    return newItems(readLstmCell(node));
  }
  if (name == "aten::gru" || name == "aten::lstm") {
    return newItems(readRecurrent(node));
  }
  std::vector<torch::Tensor> parts;
  const auto indices = [&] { return indicesOf(tensor(node, "self")); };
  if (name == "aten::chunk") {
    parts = indices().chunk(constant(node, "chunks").toInt(), constant(node, "dim").toInt());
  } else if (name == "prim::ConstantChunk") {
    parts =
        indicesOf(item(node.input(0)).tensor).chunk(node.i(torch::jit::attr::chunks), node.i(torch::jit::attr::dim));
  } else if (name == "aten::split" && node.hasNamedInput("split_size")) {
    const IValue size = constant(node, "split_size");
    const std::int64_t dim = constant(node, "dim").toInt();
    parts = size.isInt() ? indices().split(size.toInt(), dim) : indices().split_with_sizes(size.toIntVector(), dim);
  } else if (name == "aten::split_with_sizes") {
    parts = indices().split_with_sizes(constant(node, "split_sizes").toIntVector(), constant(node, "dim").toInt());
  } else if (name == "aten::unbind") {
    parts = indices().unbind(constant(node, "dim").toInt());
  }
  Items items;
  for (const torch::Tensor& part : parts) {
    const Item whole = item(node.input(0));
    const NetworkTensor tensor = moved(whole.tensor, part);
    items.push_back(is_unsafe ? newItem(tensor) : Item{tensor, whole.memory, whole.version});
  }
  return items;
}

/// Weights of a cell: of the input, of the state, and their biases, if they have any.
NetworkLayers::CellWeights TorchReader::cellWeights(const std::vector<torch::Tensor>& weights) const {
  const auto bias = [&](std::size_t index) {
    return index < weights.size() && weights[index].defined() ? std::optional<FloatTensor>(matrix(weights[index]))
                                                              : std::nullopt;
  };
  return {matrix(weights.at(0).t()), matrix(weights.at(1).t()), bias(2), bias(3)};
}

NetworkLayers::CellWeights TorchReader::weightsOfCell(const Node& node) const {
  std::vector<torch::Tensor> weights;
  for (const char* const input : {"w_ih", "w_hh", "b_ih", "b_hh"}) {
    const IValue value = constant(node, input);
    weights.push_back(value.isTensor() ? value.toTensor() : torch::Tensor());
  }
  return cellWeights(weights);
}

NetworkTensor TorchReader::readGruCell(const Node& node) {
  return layers_.cell(tensor(node, "input"), {operand(node, "hx")}, weightsOfCell(node)).front();
}

std::vector<NetworkTensor> TorchReader::readLstmCell(const Node& node) {
  return layers_.cell(tensor(node, "input"), tensorsIn(node, "hx"), weightsOfCell(node));
}

/// Layers of nn.GRU or nn.LSTM: the outputs of the last one, and the states of all.
std::vector<NetworkTensor> TorchReader::readRecurrent(const Node& node) {
  const bool is_lstm = node.kind() == torch::jit::aten::lstm;
  if (!node.hasNamedInput("batch_first") || constant(node, "bidirectional").toBool() ||
      (constant(node, "train").toBool() && numberOf(node, "dropout") != 0.0)) {
    refuse("must have one direction, no packed sequences, and no dropout in training");
  }
  const std::size_t time_axis = constant(node, "batch_first").toBool() ? 1 : 0;
  const std::vector<torch::Tensor> weights = constant(node, "params").toTensorVector();
  const auto layers = static_cast<std::size_t>(constant(node, "num_layers").toInt());
  const bool has_biases = constant(node, "has_biases").toBool();
  const std::vector<NetworkTensor> initial =
      is_lstm ? tensorsIn(node, "hx") : std::vector<NetworkTensor>{operand(node, "hx")};
  NetworkTensor sequence = tensor(node, "input");
  if (sequence.shape.size() != 3 || weights.size() != layers * (has_biases ? 4 : 2)) {
    refuse("must take a sequence of rows, [time, n, inputs] or [n, time, inputs], and have no projections");
  }
  std::vector<std::vector<NetworkTensor>> last(initial.size());
  for (std::size_t layer = 0; layer < layers; ++layer) {
    NetworkLayers::States states;
    for (const NetworkTensor& state : initial) {
      states.push_back(layers_.at(state, 0, static_cast<std::int64_t>(layer)));
    }
    const auto first = weights.begin() + static_cast<std::ptrdiff_t>(layer * weights.size() / layers);
    const std::vector<torch::Tensor> own(first, first + (has_biases ? 4 : 2));
    const NetworkLayers::Unrolled unrolled = layers_.unroll(sequence, time_axis, states, cellWeights(own));
    sequence = unrolled.outputs;
    for (std::size_t i = 0; i < last.size(); ++i) {
      last[i].push_back(moved(unrolled.states[i], indicesOf(unrolled.states[i]).unsqueeze(0)));
    }
  }
  std::vector<NetworkTensor> results = {sequence};
  for (const std::vector<NetworkTensor>& of_layers : last) {
    results.push_back(network_.concatenate(of_layers, 0));
  }
  return results;
}

}  // namespace pusht
