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
#include <utility>

#include "onnx_constants.hpp"
#include "operation_list.hpp"

namespace pusht {

/// Whether a domain is that of ONNX's own operators.
inline bool isStandard(const std::string& domain) { return domain.empty() || domain == "ai.onnx"; }

/// Follows the rows from node to node of an ONNX graph.
class OnnxReader {
 public:
  OnnxReader(std::string rows, int columns, std::int64_t opset)
      : rows_(std::move(rows)), opset_(opset), list_({1, columns}) {
    define(rows_);
  }

  void addConstant(const std::string& name, OnnxConstant constant);

  /// Throws UnfitForKernel, naming operator and node.
  void read(const onnx::NodeProto& node, int index);

  const std::string& rows() const { return rows_; }
  const OperationList& list() const { return list_; }

 private:
  using Reader = void (OnnxReader::*)(const onnx::NodeProto&);
  using Constant = std::shared_ptr<const OnnxConstant>;

  struct Operator {
    Reader read;  // null: takes constants alone
    int fewest_inputs;
    int most_inputs;
    std::set<std::string_view> attributes;
  };
  static const std::map<std::string, Operator>& operators();
  static const Operator& operatorOf(const onnx::NodeProto& node);

  void readGemm(const onnx::NodeProto& node);
  void readMatMul(const onnx::NodeProto& node);
  void readAdd(const onnx::NodeProto& node);
  void readSub(const onnx::NodeProto& node);
  void readMul(const onnx::NodeProto& node);
  void readDiv(const onnx::NodeProto& node);
  void readNeg(const onnx::NodeProto& node);
  void readRelu(const onnx::NodeProto& node);
  void readTanh(const onnx::NodeProto& node);
  void readClip(const onnx::NodeProto& node);
  void readMax(const onnx::NodeProto& node);
  void readMin(const onnx::NodeProto& node);
  void readCast(const onnx::NodeProto& node);
  void readDropout(const onnx::NodeProto& node);
  void readFlatten(const onnx::NodeProto& node);
  void readIdentity(const onnx::NodeProto& node);
  void readReshape(const onnx::NodeProto& node);

  Constant folded(const onnx::NodeProto& node) const;
  void define(const std::string& name);
  static bool has(const onnx::NodeProto& node, int input);
  Constant constantAt(const onnx::NodeProto& node, int input) const;
  const FloatTensor& operand(const onnx::NodeProto& node, int input) const;
  const FloatTensor& otherOperand(const onnx::NodeProto& node) const;
  void requireRows(const onnx::NodeProto& node) const;
  void requireRoom() const;

  std::string rows_;  // name of the rows after the last operation
  std::int64_t opset_;
  OperationList list_;
  std::map<std::string, Constant> constants_;
  std::set<std::string> names_;
  std::size_t folded_ = 0;  // numbers that nodes made of constants
};

}  // namespace pusht
