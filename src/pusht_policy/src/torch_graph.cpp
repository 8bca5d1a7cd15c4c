// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <utility>

#include "torch_network.hpp"
#include "torch_reader.hpp"

namespace pusht {

TorchReader::TorchReader(const std::vector<const Value*>& inputs, const std::vector<Sizes>& shapes) : network_(shapes) {
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    define(inputs[i], {newItem(network_.input(i))});
  }
}

TorchReader::Item TorchReader::newItem(NetworkTensor tensor) {
  versions_.push_back(0);
  return {std::move(tensor), static_cast<int>(versions_.size()) - 1, 0};
}

TorchReader::Items TorchReader::newItems(const std::vector<NetworkTensor>& tensors) {
  Items items;
  std::transform(tensors.begin(), tensors.end(), std::back_inserter(items),
                 [&](const NetworkTensor& tensor) { return newItem(tensor); });
  return items;
}

void TorchReader::define(const Value* result, Items items) {
  const bool is_list = result->type()->kind() == c10::TypeKind::ListType;
  if (items.size() == 1 && !is_list) {
    sizes_.set(result, items.front().tensor.shape);
  }
  items_[result] = std::move(items);
}

bool TorchReader::takesUnknown(const Node& node) const {
  const auto inputs = node.inputs();
  return std::any_of(inputs.begin(), inputs.end(), [&](const Value* input) { return unknown_.count(input) > 0; });
}

void TorchReader::read(const torch::jit::Block& block) {
  for (const Node* node : block.nodes()) {
    const std::string name = node->kind().toQualString();
    bool is_read = false;
    if (!takesUnknown(*node)) {
      try {
        readNode(*node);
        is_read = true;
      } catch (const UnfitForKernel& error) {
        unfit_.add(name, error.what());
      }
    }
    if (!is_read) {
      unknown_.insert(node->outputs().begin(), node->outputs().end());
    }
  }
}

void TorchReader::readNode(const Node& node) {
  if (!readStructure(node) && !GraphSizes::areComputedBy(node)) {
    readOperation(node);
  }
}

/// Lists and branches; whether it is one.
bool TorchReader::readStructure(const Node& node) {
  namespace prim = torch::jit::prim;
  const auto inputs = node.inputs();
  if (node.kind() == prim::Uninitialized) {  // result of a branch that is not taken
    unknown_.insert(node.output());
    return true;
  }
  if (node.kind() == prim::If) {
    readBranch(node);
    return true;
  }
  if (node.kind() == prim::ListConstruct || node.kind() == prim::TupleConstruct) {
    const bool grows = inputs.empty() && node.output()->type()->isSubtypeOf(*c10::ListType::ofTensors());
    const bool has_tensors =
        grows || std::any_of(inputs.begin(), inputs.end(), [&](const Value* input) { return items_.count(input) > 0; });
    Items items;
    for (std::size_t i = 0; has_tensors && i < inputs.size(); ++i) {
      items.push_back(items_.count(inputs[i]) > 0 ? item(inputs[i]) : newItem(tensorOf(inputs[i])));
    }
    if (has_tensors) {
      define(node.output(), std::move(items));
    }
    return true;  // constants are computed when they are asked for
  }
  if (inputs.empty() || items_.count(inputs[0]) == 0) {
    return false;
  }
  const Items& items = items_.at(inputs[0]);
  if (node.kind() == prim::unchecked_cast) {  // of an optional tensor that is one
    define(node.output(), items);
    return true;
  }
  if (node.kind() == torch::jit::aten::append) {
    items_[inputs[0]].push_back(item(inputs[1]));
    return true;
  }
  if (node.kind() == prim::ListUnpack || node.kind() == prim::TupleUnpack) {
    for (std::size_t i = 0; i < node.outputs().size(); ++i) {
      define(node.outputs()[i], {items.at(i)});
    }
    return true;
  }
  if (node.kind() == torch::jit::aten::__getitem__ || node.kind() == prim::TupleIndex) {
    const auto index = sizes_.valueOf(inputs[1]);
    define(node.output(), {items.at(axisOf(index ? index->toInt() : 0, items.size()))});
    return index.has_value();
  }
  return false;
}

/// The branch that the shapes decide for.
void TorchReader::readBranch(const Node& node) {
  const auto condition = sizes_.valueOf(node.input(0));
  if (!condition) {
    refuse("its condition must not depend on numbers");
  }
  const torch::jit::Block& taken = *node.blocks()[condition->toBool() ? 0 : 1];
  read(taken);
  for (std::size_t i = 0; i < node.outputs().size(); ++i) {
    const Value* const result = taken.outputs()[i];
    if (unknown_.count(result) > 0) {
      unknown_.insert(node.outputs()[i]);
    } else if (const auto known = items_.find(result); known != items_.end()) {
      define(node.outputs()[i], known->second);
    } else {
      sizes_.setSame(node.outputs()[i], result);
    }
  }
}

void TorchReader::readOperation(const Node& node) {
  std::string name = node.kind().toQualString();
  const bool in_place = name.back() == '_';
  if (in_place) {
    name.pop_back();
  }
  if (Items parts = readParts(node); !parts.empty()) {
    if (node.outputs().size() == 1) {
      return define(node.output(), std::move(parts));
    }
    for (std::size_t i = 0; i < node.outputs().size(); ++i) {
      define(node.outputs()[i], {parts.at(i)});
    }
    return;
  }
  const auto reader = readers().find(name);
  if (reader == readers().end()) {
    unfit_.addUnknown(name);
    unknown_.insert(node.outputs().begin(), node.outputs().end());
    return;
  }
  Item result = newItem((this->*reader->second)(node));
  if (in_place || views().count(name) > 0) {
    const Item& original = item(node.input(0));
    result.memory = original.memory;
    result.version = in_place ? ++versions_[original.memory] : original.version;
  }
  if (in_place) {
    define(node.input(0), {result});
  }
  define(node.output(), {std::move(result)});
}

std::vector<Operation> TorchReader::finish(const std::vector<const Value*>& results) {
  if (!unfit_.empty()) {
    throw UnfitForKernel(unfit_.text());
  }
  std::vector<NetworkTensor> tensors;
  std::transform(results.begin(), results.end(), std::back_inserter(tensors),
                 [&](const Value* result) { return tensorOf(result); });
  return network_.finish(tensors);
}

void TorchReader::refuse(const std::string& why) { throw UnfitForKernel(why); }

const TorchReader::Item& TorchReader::item(const Value* value) const {
  const auto found = items_.find(value);
  if (found == items_.end() || found->second.size() != 1) {
    refuse("its operand must be a tensor");
  }
  const Item& item = found->second.front();
  requireUpToDate(item);
  return item;
}

void TorchReader::requireUpToDate(const Item& item) const {
  if (item.version != versions_[item.memory]) {
    refuse("must not take a tensor that an operation in place has changed since");
  }
}

TorchReader::IValue TorchReader::constant(const Node& node, const char* input) const {
  const auto value = sizes_.valueOf(node.namedInput(input));
  if (!value) {
    refuse(std::string("its operand ") + input + " must be constant");
  }
  return *value;
}

bool TorchReader::hasOperand(const Node& node, const char* input) const {
  return node.hasNamedInput(input) && (items_.count(node.namedInput(input)) > 0 || !constant(node, input).isNone());
}

NetworkTensor TorchReader::tensor(const Node& node, const char* input) const {
  return item(node.namedInput(input)).tensor;
}

/// Tensor or constant: a number for all columns or a tensor.
NetworkTensor TorchReader::operand(const Node& node, const char* input) const {
  return tensorOf(node.namedInput(input));
}

NetworkTensor TorchReader::tensorOf(const Value* source) const {
  if (items_.count(source) > 0) {
    return item(source).tensor;
  }
  const auto known = sizes_.valueOf(source);
  if (!known) {
    refuse("its operand must be constant or a tensor");
  }
  const IValue& value = *known;
  if (!value.isScalar() && !value.isTensor()) {
    refuse("its operand must be a number or a tensor");
  }
  torch::Tensor values = value.isTensor() ? value.toTensor() : torch::scalar_tensor(value.toScalar());
  if (values.dim() == 0) {  // as torch takes it, whatever its type: in the type of the rows
    values = values.to(torch::kFloat32);
  }
  if (values.scalar_type() != torch::kFloat32) {
    refuse("its operand must be float32");
  }
  return NetworkBuilder::constant({values.sizes().vec(), toVector(values)});
}

FloatTensor TorchReader::matrix(const IValue& value) const {
  if (!value.isTensor() || value.toTensor().scalar_type() != torch::kFloat32) {
    refuse("its matrix must be float32");
  }
  return {value.toTensor().sizes().vec(), toVector(value.toTensor())};
}

void TorchReader::requireOne(const Node& node, const char* input) const {
  const IValue value = constant(node, input);
  if (!value.isScalar() || value.toScalar().toDouble() != 1.0) {
    refuse(std::string("its ") + input + " must be 1");
  }
}

std::vector<std::int64_t> TorchReader::axes(const Node& node, const char* input) const {
  const IValue value = constant(node, input);
  return value.isInt() ? std::vector<std::int64_t>{value.toInt()} : value.toIntVector();
}

namespace {

/// Operations of a graph, as far as they can be read.
std::vector<Operation> readOperations(const torch::jit::Graph& graph, const std::vector<Sizes>& shapes,
                                      bool has_state) {
  if (graph.inputs().size() != 1 + shapes.size() || graph.outputs().size() != 1) {
    throw UnfitForKernel("forward must take what its description says and return one result");
  }
  const std::vector<const torch::jit::Value*> inputs(graph.inputs().begin() + 1, graph.inputs().end());
  TorchReader reader(inputs, shapes);
  reader.read(*graph.block());
  const torch::jit::Value* const result = graph.outputs()[0];
  const torch::jit::Node& last = *result->node();
  if (!has_state) {
    return reader.finish({result});
  }
  if (last.kind() != torch::jit::prim::TupleConstruct) {
    throw UnfitForKernel("forward must return a tuple that it makes at its end");
  }
  return reader.finish({last.inputs().begin(), last.inputs().end()});
}

}  // namespace

std::vector<float> toVector(const at::Tensor& tensor) {
  const torch::Tensor values = tensor.contiguous();
  return {values.data_ptr<float>(), values.data_ptr<float>() + values.numel()};
}

std::vector<Operation> readGraph(const torch::jit::Graph& graph, const std::vector<Sizes>& shapes, bool has_state) {
  try {
    return readOperations(graph, shapes, has_state);
  } catch (const UnfitForKernel&) {
    throw;
  } catch (const std::exception& error) {
    throw UnfitForKernel("cannot be read: " + firstLine(error));
  }
}

}  // namespace pusht
