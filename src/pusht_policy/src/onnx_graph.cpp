// SPDX-License-Identifier: BSD-3-Clause
#include "onnx_graph.hpp"

#include <onnx/onnx_pb.h>

#include <algorithm>
#include <set>

#include "onnx_reader.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/joined.hpp"

namespace pusht {
namespace {

using onnx::TensorProto;

/// Type for a message: "FLOAT [n, 10]".
std::string describe(const onnx::TypeProto::Tensor& tensor) {
  const int type = tensor.elem_type();
  std::vector<std::string> dimensions;
  for (const auto& dimension : tensor.shape().dim()) {
    constexpr int kEnough = 8;
    if (dimensions.size() == kEnough) {
      dimensions.emplace_back("...");
      break;
    }
    dimensions.push_back(dimension.has_dim_value()   ? std::to_string(dimension.dim_value())
                         : dimension.has_dim_param() ? quoted(dimension.dim_param())
                                                     : "?");
  }
  return (onnx::TensorProto_DataType_IsValid(type)
              ? onnx::TensorProto_DataType_Name(static_cast<onnx::TensorProto_DataType>(type))
              : "type " + std::to_string(type)) +
         (tensor.has_shape() ? " [" + (dimensions.empty() ? "" : joined(dimensions)) + "]" : " of any shape");
}

/// Shape for a message, where the first axis is that of rollouts: "[n, 10]".
std::string rowsOf(const Sizes& shape, const std::string& rollouts) {
  std::vector<std::string> dimensions = {rollouts};
  std::transform(shape.begin() + 1, shape.end(), std::back_inserter(dimensions),
                 [](std::int64_t size) { return std::to_string(size); });
  return "[" + joined(dimensions) + "]";
}

/// Throws BadDependency unless the value is declared as float32 of this shape, for one rollout or for many. What a file
/// leaves open about an output, the operations decide.
void requireShape(const Sizes& shape, const onnx::ValueInfoProto& value, bool is_input) {
  const onnx::TypeProto::Tensor& tensor = value.type().tensor_type();
  bool fits = tensor.has_shape() && tensor.shape().dim_size() == static_cast<int>(shape.size());
  for (int axis = 0; fits && axis < tensor.shape().dim_size(); ++axis) {
    const auto& dimension = tensor.shape().dim(axis);
    fits = dimension.has_dim_value() ? dimension.dim_value() == shape[axis] : (axis == 0 || !is_input);
  }
  if (tensor.elem_type() != TensorProto::FLOAT || !(fits || (!is_input && !tensor.has_shape()))) {
    throw BadDependency((is_input ? "input " : "output ") + quoted(value.name()) + ": must be FLOAT " +
                        rowsOf(shape, "n") + " or " + rowsOf(shape, "1") + ", but is " +
                        (value.type().has_tensor_type() ? describe(tensor) : "no tensor"));
  }
}

/// Throws InvalidInput unless protobuf can read the bytes.
onnx::ModelProto parsed(const std::string& bytes) {
  if (bytes.empty()) {
    throw InvalidInput("must be ONNX, but is empty");
  }
  if (bytes.compare(0, 4, "PK\3\4") == 0) {
    throw InvalidInput("must be ONNX, as its name says, but is a zip archive, as TorchScript is: name it .ts.pt");
  }
  onnx::ModelProto model;
  if (!model.ParseFromString(bytes)) {
    throw InvalidInput("must be ONNX: protobuf cannot read it; it is cut off, damaged or something else");
  }
  return model;
}

/// Version of ONNX's operators. Throws InvalidInput if the model is of another time, or has operators of its own.
std::int64_t opsetOf(const onnx::ModelProto& model) {
  constexpr std::int64_t kOldestFormat = 3;   // since ONNX 1.0; the first whose operators have versions
  constexpr std::int64_t kNewestFormat = 10;  // ONNX 1.17
  if (model.ir_version() < kOldestFormat || model.ir_version() > kNewestFormat || !model.has_graph()) {
    throw InvalidInput("must be ONNX with a graph and ir_version " + std::to_string(kOldestFormat) + " to " +
                       std::to_string(kNewestFormat) + ", but has ir_version " + std::to_string(model.ir_version()));
  }
  if (model.functions_size() > 0) {
    throw InvalidInput("must have no functions of its own, but has " + quoted(model.functions(0).name()));
  }
  std::set<std::int64_t> opsets;
  for (const onnx::OperatorSetIdProto& import : model.opset_import()) {
    if (isStandard(import.domain())) {
      opsets.insert(import.version());
    }
  }
  if (opsets.size() != 1) {
    throw InvalidInput("must name one opset of ONNX, but names " + std::to_string(opsets.size()));
  }
  if (*opsets.begin() < kOldestOpset || *opsets.begin() > kNewestOpset) {
    throw InvalidInput("opset " + std::to_string(*opsets.begin()) + ": must be from " + std::to_string(kOldestOpset) +
                       " to " + std::to_string(kNewestOpset));
  }
  return *opsets.begin();
}

using Infos = std::vector<const onnx::ValueInfoProto*>;

/// Values with their types, for a message: "'x' FLOAT ['n', 10], 'h' FLOAT ['n', 64]".
std::string typesOf(const Infos& values) {
  std::vector<std::string> texts;
  texts.reserve(values.size());
  for (const onnx::ValueInfoProto* value : values) {
    texts.push_back(quoted(value->name()) + " " +
                    (value->type().has_tensor_type() ? describe(value->type().tensor_type()) : "no tensor"));
  }
  return joined(texts);
}

/// Inputs of the graph that are no initializers: older files list those, too.
Infos inputsOf(const onnx::GraphProto& graph) {
  std::set<std::string> initializers;
  for (const TensorProto& tensor : graph.initializer()) {
    initializers.insert(tensor.name());
  }
  Infos inputs;
  for (const onnx::ValueInfoProto& input : graph.input()) {
    if (initializers.count(input.name()) == 0) {
      inputs.push_back(&input);
    }
  }
  return inputs;
}

/// Description in the metadata of the model; the plain contract if there is none. Throws InvalidInput if it is bad.
PolicyDescription descriptionOf(const onnx::ModelProto& model) {
  for (const onnx::StringStringEntryProto& entry : model.metadata_props()) {
    if (entry.key() == kDescriptionFile) {
      return descriptionFrom(entry.value(), kDescriptionFile);
    }
  }
  return {};
}

/// Shape of a tensor for one rollout.
Sizes ofOneRollout(const PolicyDescription::Shape& shape) {
  Sizes sizes = {1};
  sizes.insert(sizes.end(), shape.begin(), shape.end());
  return sizes;
}

/// Shapes of what goes in, or comes out, by the description.
std::vector<Sizes> shapesBy(const PolicyDescription& description, bool are_inputs) {
  constexpr int kAction = std::tuple_size<Action>::value;
  const int columns = are_inputs ? description.interface.numbers() : kAction;
  const int times = are_inputs ? description.observations : description.actions;
  std::vector<Sizes> shapes = {description.described ? Sizes{1, times, columns} : Sizes{1, columns}};
  if (!description.state.empty()) {
    shapes.push_back(ofOneRollout(description.state));
  }
  if (are_inputs && !description.noise.empty()) {
    shapes.push_back(ofOneRollout(description.noise));
  }
  return shapes;
}

/// Throws BadDependency unless these are as many as the description says, with its shapes.
void requireSignature(const Infos& values, const std::vector<Sizes>& shapes, bool are_inputs) {
  const std::string what = are_inputs ? "input" : "output";
  if (values.size() != shapes.size()) {
    throw BadDependency("must have " + std::to_string(shapes.size()) + " " + what + (shapes.size() == 1 ? "" : "s") +
                        ", as its description says (" + kDescriptionFile + " in its metadata; none: one), but has " +
                        std::to_string(values.size()) + ": " + typesOf(values));
  }
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    requireShape(shapes[i], *values[i], are_inputs);
  }
}

std::vector<std::string> namesOf(const Infos& values) {
  std::vector<std::string> names;
  names.reserve(values.size());
  for (const onnx::ValueInfoProto* value : values) {
    names.push_back(value->name());
  }
  return names;
}

/// Operations of the graph, from inputs to outputs of these shapes.
std::vector<Operation> operationsOf(const onnx::GraphProto& graph, OnnxReader& reader, OnnxDataFiles& files,
                                    const Infos& outputs, const std::vector<Sizes>& shapes) {
  for (const TensorProto& tensor : graph.initializer()) {
    reader.addConstant(tensor.name(), readTensor(tensor, tensor.name(), files));
  }
  for (int i = 0; i < graph.node_size(); ++i) {
    reader.read(graph.node(i), i);
  }
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const Sizes& shape = reader.shapeOf(outputs[i]->name());
    if (shape != shapes[i]) {
      throw BadDependency("output " + quoted(outputs[i]->name()) + ": must be " + textOf(shapes[i]) +
                          " for one rollout, but is " + textOf(shape));
    }
  }
  return reader.finish(namesOf(outputs));
}

}  // namespace

OnnxNetwork readOnnx(const std::string& bytes, const std::filesystem::path& folder) {
  const onnx::ModelProto model = parsed(bytes);
  OnnxNetwork network;
  network.opset = opsetOf(model);
  network.producer = model.producer_name() + " " + model.producer_version();
  network.description = descriptionOf(model);
  const onnx::GraphProto& graph = model.graph();
  const Infos inputs = inputsOf(graph);
  Infos outputs;
  for (const onnx::ValueInfoProto& output : graph.output()) {
    outputs.push_back(&output);
  }
  const std::vector<Sizes> input_shapes = shapesBy(network.description, true);
  const std::vector<Sizes> output_shapes = shapesBy(network.description, false);
  requireSignature(inputs, input_shapes, true);
  requireSignature(outputs, output_shapes, false);
  try {
    OnnxDataFiles files(folder);
    OnnxReader reader(namesOf(inputs), input_shapes, network.opset, files);
    network.operations = operationsOf(graph, reader, files, outputs, output_shapes);
    network.data_files = files.hashes();
    return network;
  } catch (const UnfitForKernel& error) {
    throw InvalidInput(error.what() + std::string("; docs/networks.md says what runs, and what to do"));
  }
}

}  // namespace pusht
