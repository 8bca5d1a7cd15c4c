// SPDX-License-Identifier: BSD-3-Clause
#include <onnx/onnx_pb.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "onnx_reader.hpp"
#include "pusht_task/error.hpp"

namespace pusht {
namespace {

const onnx::AttributeProto* attributeOf(const onnx::NodeProto& node, const char* name) {
  const auto found = std::find_if(node.attribute().begin(), node.attribute().end(),
                                  [&](const onnx::AttributeProto& attribute) { return attribute.name() == name; });
  return found == node.attribute().end() ? nullptr : &*found;
}

}  // namespace

bool hasAttribute(const onnx::NodeProto& node, const char* name) { return attributeOf(node, name) != nullptr; }

float floatOf(const onnx::NodeProto& node, const char* name, float otherwise) {
  const onnx::AttributeProto* const attribute = attributeOf(node, name);
  if (attribute != nullptr && (!attribute->has_f() || !std::isfinite(attribute->f()))) {
    throw UnfitForKernel(std::string("its ") + name + " must be a finite number");
  }
  return attribute == nullptr ? otherwise : attribute->f();
}

std::int64_t integerOf(const onnx::NodeProto& node, const char* name, std::int64_t otherwise) {
  const onnx::AttributeProto* const attribute = attributeOf(node, name);
  if (attribute != nullptr && !attribute->has_i()) {
    throw UnfitForKernel(std::string("its ") + name + " must be an integer");
  }
  return attribute == nullptr ? otherwise : attribute->i();
}

std::string textOf(const onnx::NodeProto& node, const char* name) {
  const onnx::AttributeProto* const attribute = attributeOf(node, name);
  return attribute == nullptr ? "" : attribute->s();
}

Sizes integersOf(const onnx::NodeProto& node, const char* name) {
  const onnx::AttributeProto* const attribute = attributeOf(node, name);
  return attribute == nullptr ? Sizes{} : Sizes(attribute->ints().begin(), attribute->ints().end());
}

OnnxReader::OnnxReader(const std::vector<std::string>& inputs, const std::vector<Sizes>& shapes, std::int64_t opset,
                       OnnxDataFiles& files)
    : opset_(opset), files_(files), network_(shapes) {
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    define(inputs[i]);
    values_[inputs[i]] = {network_.input(i)};
  }
}

void OnnxReader::define(const std::string& name) {
  if (name.empty() || !names_.insert(name).second) {
    throw InvalidInput("name " + quoted(name) + ": must be given to one tensor");
  }
}

OnnxReader::Value OnnxReader::number(OnnxConstant constant) {
  if (constant.type == onnx::TensorProto::FLOAT) {
    return {NetworkBuilder::constant(std::move(constant.tensor))};
  }
  return {{}, std::make_shared<const OnnxConstant>(std::move(constant))};
}

void OnnxReader::addConstant(const std::string& name, OnnxConstant constant) {
  define(name);
  values_[name] = number(std::move(constant));
}

void OnnxReader::read(const Node& node, int index) {
  for (const std::string& output : node.output()) {
    if (&output == &node.output(0) || !output.empty()) {
      define(output);
    }
  }
  const auto is_unknown = [&](const std::string& name) { return unknown_.count(name) > 0; };
  const std::string domain = isStandard(node.domain()) ? "" : node.domain() + ".";
  const std::string name = "operator " + quoted(domain + node.op_type()) + " of node " +
                           (node.name().empty() ? std::to_string(index) : quoted(node.name()));
  const auto known = operators().find(domain + node.op_type());
  if (known == operators().end()) {
    if (unknown_operators_.insert(domain + node.op_type()).second) {
      unfit_.addUnknown(name);
    }
  } else if (std::none_of(node.input().begin(), node.input().end(), is_unknown)) {
    try {
      return readKnown(known->second, node);
    } catch (const UnfitForKernel& error) {
      unfit_.add(name, error.what());
    }
  }
  unknown_.insert(node.output().begin(), node.output().end());
}

void OnnxReader::readKnown(const Operator& known, const Node& node) {
  if (node.input_size() < known.fewest_inputs || node.input_size() > known.most_inputs || node.output_size() < 1) {
    throw UnfitForKernel("must have " + std::to_string(known.fewest_inputs) + " to " +
                         std::to_string(known.most_inputs) + " inputs and an output, but has " +
                         std::to_string(node.input_size()) + " inputs");
  }
  for (const onnx::AttributeProto& attribute : node.attribute()) {
    if (known.attributes.count(attribute.name()) == 0 || attribute.has_ref_attr_name()) {
      throw UnfitForKernel("its attribute " + quoted(attribute.name()) + " is not known to the kernel");
    }
  }
  Values results = (this->*known.read)(node);
  requireRoom();
  for (std::size_t i = 0; i < std::min<std::size_t>(results.size(), node.output_size()); ++i) {
    values_[node.output(static_cast<int>(i))] = std::move(results[i]);
  }
}

void OnnxReader::requireRoom() {
  constexpr std::size_t kMostNumbers = std::size_t{1} << 26U;  // 268 MB; a small file may use one matrix many times
  if (network_.numbers() + other_numbers_ > kMostNumbers) {
    throw UnfitForKernel("the network must have at most " + std::to_string(kMostNumbers) + " numbers up to here");
  }
}

const OnnxReader::Value& OnnxReader::value(const Node& node, int input) const {
  const auto found = values_.find(input < node.input_size() ? node.input(input) : "");
  if (found == values_.end()) {
    throw UnfitForKernel("its operand " + quoted(input < node.input_size() ? node.input(input) : "") +
                         " must be the result of an operation before it");
  }
  return found->second;
}

const NetworkTensor& OnnxReader::tensor(const Node& node, int input) const {
  const Value& value = this->value(node, input);
  if (value.other != nullptr) {
    throw UnfitForKernel("its operand " + quoted(node.input(input)) + " must be float32");
  }
  return value.tensor;
}

const FloatTensor& OnnxReader::constant(const Node& node, int input) const {
  const NetworkTensor& tensor = this->tensor(node, input);
  if (!tensor.isConstant()) {
    throw UnfitForKernel("its operand " + quoted(node.input(input)) + " must be constant");
  }
  return *tensor.constant;
}

const std::vector<double>& OnnxReader::numbers(const Node& node, int input) const {
  const Value& value = this->value(node, input);
  if (value.other == nullptr) {
    throw UnfitForKernel("its operand " + quoted(node.input(input)) + " must be constant integers");
  }
  return value.other->numbers;
}

Sizes OnnxReader::integers(const Node& node, int input) const {
  static constexpr double kMost = 1e15;
  const std::vector<double>& numbers = this->numbers(node, input);
  Sizes integers(numbers.size());
  std::transform(numbers.begin(), numbers.end(), integers.begin(), [](double number) {
    return static_cast<std::int64_t>(std::clamp(number, -kMost, kMost));  // bounds of a slice may be the largest number
  });
  return integers;
}

/// Axes of an operator: an attribute before an opset, the second input from then on.
Sizes OnnxReader::axesOf(const Node& node, std::int64_t inputs_since, const Value& of) const {
  Sizes axes = has(node, 1) ? integers(node, 1) : integersOf(node, "axes");
  if (has(node, 1) && opset_ < inputs_since) {
    throw UnfitForKernel("its axes must be an attribute in opset " + std::to_string(opset_));
  }
  for (std::int64_t& axis : axes) {
    axis = static_cast<std::int64_t>(axisOf(axis, of.shape().size()));
  }
  return axes;
}

OnnxReader::Value OnnxReader::select(const Value& value, const Selection& selection) {
  if (value.other == nullptr) {
    return {network_.select({value.tensor}, selection)};
  }
  OnnxConstant selected{value.other->type, {selection.shape, {}}, {}};
  for (const int element : selection.elements) {
    selected.numbers.push_back(value.other->numbers.at(element));
  }
  other_numbers_ += selected.numbers.size();
  return number(std::move(selected));
}

const Sizes& OnnxReader::shapeOf(const std::string& result) const {
  if (!unfit_.empty()) {
    throw UnfitForKernel(unfit_.text());
  }
  const auto found = values_.find(result);
  if (found == values_.end() || found->second.other != nullptr) {
    throw UnfitForKernel("output " + quoted(result) + ": must be the result of an operation, in float32");
  }
  return found->second.shape();
}

std::vector<Operation> OnnxReader::finish(const std::vector<std::string>& results) {
  std::vector<NetworkTensor> tensors;
  std::transform(results.begin(), results.end(), std::back_inserter(tensors),
                 [&](const std::string& result) { return values_.at(result).tensor; });
  return network_.finish(tensors);
}

}  // namespace pusht
