// SPDX-License-Identifier: BSD-3-Clause
/// Reader of TorchScript graphs: operations on tensors as a network of the kernel.
#pragma once

#include <torch/script.h>

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "graph_sizes.hpp"
#include "network_builder.hpp"
#include "network_layers.hpp"
#include "unfit_operations.hpp"

namespace pusht {

/// Reads one node after the other. What it cannot read is collected, and with it what depends on that.
class TorchReader {
 public:
  /// `inputs` of the graph have these shapes for one rollout.
  TorchReader(const std::vector<const torch::jit::Value*>& inputs, const std::vector<Sizes>& shapes);

  void read(const torch::jit::Block& block);

  /// Operations that compute these results. Throws UnfitForKernel, naming all that could not be read.
  std::vector<Operation> finish(const std::vector<const torch::jit::Value*>& results);

 private:
  using Node = torch::jit::Node;
  using Value = torch::jit::Value;
  using IValue = torch::jit::IValue;
  using Reader = NetworkTensor (TorchReader::*)(const Node&);

  /// Tensor with the memory that it lies in: an operation in place makes all others out of date that share it.
  struct Item {
    NetworkTensor tensor;
    int memory;
    int version;
  };
  using Items = std::vector<Item>;  // of a list, its elements

  static const std::map<std::string, Reader>& readers();
  static const std::set<std::string>& views();

  void readNode(const Node& node);
  bool readStructure(const Node& node);
  void readBranch(const Node& node);
  void readOperation(const Node& node);
  Items readParts(const Node& node);
  std::vector<NetworkTensor> readLstmCell(const Node& node);
  std::vector<NetworkTensor> readRecurrent(const Node& node);
  void define(const Value* result, Items items);
  Item newItem(NetworkTensor tensor);
  Items newItems(const std::vector<NetworkTensor>& tensors);
  bool takesUnknown(const Node& node) const;

  // Operands.
  [[noreturn]] static void refuse(const std::string& why);
  IValue constant(const Node& node, const char* input) const;
  double numberOf(const Node& node, const char* input) const { return constant(node, input).toScalar().toDouble(); }
  const Item& item(const Value* value) const;
  void requireUpToDate(const Item& item) const;
  NetworkTensor tensorOf(const Value* value) const;
  NetworkTensor tensor(const Node& node, const char* input) const;
  NetworkTensor operand(const Node& node, const char* input) const;
  bool hasOperand(const Node& node, const char* input) const;
  FloatTensor matrix(const IValue& value) const;
  void requireOne(const Node& node, const char* input) const;
  std::optional<NetworkTensor> optional(const Node& node, const char* input) const;
  std::vector<std::int64_t> axes(const Node& node, const char* input) const;
  std::vector<std::int64_t> reducedAxes(const Node& node) const;
  Sizes reducedShape(const Node& node) const;

  // Tensors of indices, on which libtorch itself does what moves numbers.
  static torch::Tensor indicesOf(const NetworkTensor& tensor);
  NetworkTensor moved(const NetworkTensor& tensor, const torch::Tensor& indices);

  template <Operation::Kind kKind>
  NetworkTensor readFunction(const Node& node) {
    return network_.apply(kKind, tensor(node, "self"));
  }
  template <Operation::Kind kKind>
  NetworkTensor readCombination(const Node& node) {
    const NetworkTensor left = operand(node, "self");
    return network_.combine(kKind, left, operand(node, "other"));
  }
  template <NetworkTensor (NetworkLayers::*kLayer)(const NetworkTensor&)>
  NetworkTensor readLayer(const Node& node) {
    return (layers_.*kLayer)(tensor(node, "self"));
  }

  NetworkTensor readLinear(const Node& node);
  NetworkTensor readAddmm(const Node& node);
  NetworkTensor readMatmul(const Node& node);
  NetworkTensor readAdd(const Node& node);
  NetworkTensor readSub(const Node& node);
  NetworkTensor readRsub(const Node& node);
  NetworkTensor readDiv(const Node& node);
  NetworkTensor readReciprocal(const Node& node);
  NetworkTensor readRsqrt(const Node& node);
  NetworkTensor readPow(const Node& node);
  NetworkTensor readRelu(const Node& node);
  NetworkTensor readRelu6(const Node& node);
  NetworkTensor readClamp(const Node& node);
  NetworkTensor readHardtanh(const Node& node);
  NetworkTensor readElu(const Node& node);
  NetworkTensor readCelu(const Node& node);
  NetworkTensor readGelu(const Node& node);
  NetworkTensor readLeakyRelu(const Node& node);
  NetworkTensor readPrelu(const Node& node);
  NetworkTensor readSoftplus(const Node& node);
  NetworkTensor readLogSigmoid(const Node& node);
  NetworkTensor readHardSigmoid(const Node& node);
  NetworkTensor readMean(const Node& node);
  NetworkTensor readSum(const Node& node);
  NetworkTensor readLayerNorm(const Node& node);
  NetworkTensor readBatchNorm(const Node& node);
  NetworkTensor readTo(const Node& node);
  NetworkTensor readDropout(const Node& node);
  NetworkTensor readCopy(const Node& node) { return tensor(node, "self"); }
  NetworkTensor readFilled(const Node& node);
  NetworkTensor readGlu(const Node& node);
  NetworkTensor readFlatten(const Node& node);
  NetworkTensor readReshape(const Node& node);
  NetworkTensor readUnflatten(const Node& node);
  NetworkTensor readUnsqueeze(const Node& node);
  NetworkTensor readSqueeze(const Node& node);
  NetworkTensor readSlice(const Node& node);
  NetworkTensor readNarrow(const Node& node);
  NetworkTensor readSelect(const Node& node);
  NetworkTensor readIndex(const Node& node);
  NetworkTensor readIndexSelect(const Node& node);
  NetworkTensor readTranspose(const Node& node);
  NetworkTensor readMatrixTranspose(const Node& node);
  NetworkTensor readPermute(const Node& node);
  NetworkTensor readExpand(const Node& node);
  NetworkTensor readExpandAs(const Node& node);
  NetworkTensor readRepeat(const Node& node);
  NetworkTensor readCat(const Node& node);
  NetworkTensor readStack(const Node& node);
  NetworkTensor readGruCell(const Node& node);

  NetworkLayers::CellWeights cellWeights(const std::vector<torch::Tensor>& weights) const;
  NetworkLayers::CellWeights weightsOfCell(const Node& node) const;
  std::vector<NetworkTensor> tensorsIn(const Node& node, const char* input) const;

  NetworkBuilder network_;
  NetworkLayers layers_{network_};
  GraphSizes sizes_;
  std::map<const Value*, Items> items_;
  std::vector<int> versions_;       // of each memory
  std::set<const Value*> unknown_;  // results of operations that could not be read
  UnfitOperations unfit_;
};

}  // namespace pusht
