// SPDX-License-Identifier: BSD-3-Clause
// Which networks in ONNX are recognized, as what, and what is refused.
#include "../src/onnx_graph.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <ostream>
#include <string>
#include <vector>

#include "onnx_testing.hpp"
#include "pusht_task/error.hpp"

namespace pusht {
namespace {

using ::testing::HasSubstr;
using testing::integerAttribute;
using ::testing::Not;
using testing::onnxModel;
using testing::op;
using testing::realAttribute;
using testing::tensorAttribute;

OnnxNetwork readModel(const onnx::ModelProto& model) { return readOnnx(model.SerializeAsString()); }

std::string operationsOf(const onnx::ModelProto& model) {
  return NetworkKernel(10, readModel(model).operations).operations();
}

const char* const kShapeOfRows = "dims: 2 data_type: 7 int64_data: [-1, 10]";

struct OnnxSpelling {
  const char* name;
  std::string nodes;
  const char* expected;  ///< the kernel's operations
  std::int64_t opset = 14;
};

std::ostream& operator<<(std::ostream& stream, const OnnxSpelling& spelling) { return stream << spelling.name; }

class SpelledInOnnx : public ::testing::TestWithParam<OnnxSpelling> {};

TEST_P(SpelledInOnnx, IsTheKernelsOperations) {
  EXPECT_EQ(operationsOf(onnxModel(GetParam().nodes, GetParam().opset)), GetParam().expected);
}

INSTANTIATE_TEST_SUITE_P(
    , SpelledInOnnx,
    ::testing::Values(
        OnnxSpelling{"Gemm", op("Gemm", {"x", "w", "b"}, "y"), "10, matrix 2, add"},
        OnnxSpelling{"GemmWithoutBias", op("Gemm", {"x", "w"}, "y"), "10, matrix 2"},
        OnnxSpelling{"GemmWithFactors",
                     op("Gemm", {"x", "w_t", "row"}, "y",
                        realAttribute("alpha", "0.5") + realAttribute("beta", "2") + integerAttribute("transB", "1")),
                     "10, matrix 2, multiply, add"},
        OnnxSpelling{"MatMulAndAdd", op("MatMul", {"x", "w"}, "h") + op("Add", {"b", "h"}, "y"), "10, matrix 2, add"},
        OnnxSpelling{"Elementwise",
                     op("Sub", {"x", "low"}, "a") + op("Mul", {"number", "a"}, "c") + op("Div", {"c", "one"}, "d") +
                         op("Add", {"d", "number"}, "e") + op("Neg", {"e"}, "f") + op("Sub", {"one", "f"}, "g") +
                         op("MatMul", {"g", "w"}, "y"),
                     "10, subtract, multiply, divide, add, multiply, multiply, add, matrix 2"},
        OnnxSpelling{"Activations",
                     op("MatMul", {"x", "w0"}, "a") + op("Relu", {"a"}, "c") + op("Max", {"c", "b0"}, "d") +
                         op("Min", {"number", "d"}, "e") + op("MatMul", {"e", "w1"}, "f") + op("Tanh", {"f"}, "y"),
                     "10, matrix 24, max, max, min, matrix 2, tanh"},
        OnnxSpelling{"ClipWithInputs", op("MatMul", {"x", "w"}, "a") + op("Clip", {"a", "number", "one"}, "y"),
                     "10, matrix 2, max, min"},
        OnnxSpelling{"ClipFromAbove", op("MatMul", {"x", "w"}, "a") + op("Clip", {"a", "", "one"}, "y"),
                     "10, matrix 2, min"},
        OnnxSpelling{"ClipWithAttributes",
                     op("MatMul", {"x", "w"}, "a") +
                         op("Clip", {"a"}, "y", realAttribute("min", "-1") + realAttribute("max", "1")),
                     "10, matrix 2, max, min", 10},
        OnnxSpelling{"ConstantNodes",
                     op("Constant", {}, "c", tensorAttribute("data_type: 1 float_data: 2.5")) +
                         op("Constant", {}, "d", realAttribute("value_float", "0.25")) +
                         op("Constant", {}, "e", "attribute { name: 'value_floats' type: FLOATS floats: [1, 2] }") +
                         op("Mul", {"x", "c"}, "f") + op("Sub", {"f", "d"}, "g") + op("MatMul", {"g", "w"}, "h") +
                         op("Div", {"h", "e"}, "y"),
                     "10, multiply, subtract, matrix 2, divide"},
        OnnxSpelling{"ConstantsOfConstants",
                     op("Transpose", {"w_t"}, "m") + op("Identity", {"b"}, "c") +
                         op("Constant", {}, "d", tensorAttribute("data_type: 11 double_data: 0.1")) +
                         op("Cast", {"d"}, "e", integerAttribute("to", "1")) + op("MatMul", {"x", "m"}, "f") +
                         op("Add", {"f", "c"}, "g") + op("Mul", {"g", "e"}, "y"),
                     "10, matrix 2, add, multiply"},
        OnnxSpelling{
            "SeveralPaths",
            op("MatMul", {"x", "w0"}, "a") + op("Split", {"a"}, "c", "output: 'd' " + integerAttribute("axis", "1")) +
                op("Mul", {"c", "d"}, "e") + op("Concat", {"e", "x", "c"}, "f", integerAttribute("axis", "-1")) +
                op("Constant", {}, "first", tensorAttribute("dims: 1 data_type: 7 int64_data: 3")) +
                op("Constant", {}, "end", tensorAttribute("dims: 1 data_type: 7 int64_data: -1")) +
                op("Constant", {}, "last", tensorAttribute("dims: 1 data_type: 7 int64_data: 1")) +
                op("Slice", {"f", "first", "end", "last"}, "g") +
                op("Constant", {}, "which", tensorAttribute("dims: 2 data_type: 7 int64_data: [0, -1]")) +
                op("Gather", {"g", "which"}, "h", integerAttribute("axis", "1")) + op("Add", {"h", "b"}, "y"),
            "10, matrix 24, pick 12, pick 12 (1), multiply (2, 3), pick 34 (4, 0, 2), pick 30, pick 2, add"},
        OnnxSpelling{"Functions",
                     op("MatMul", {"x", "w"}, "a") + op("Sigmoid", {"a"}, "c") + op("Mul", {"a", "c"}, "d") +
                         op("Elu", {"d"}, "e") + op("Softplus", {"e"}, "f") + op("Erf", {"f"}, "g") +
                         op("Exp", {"g"}, "h") + op("Log", {"h"}, "i") + op("LeakyRelu", {"i"}, "y"),
                     "10, matrix 2, sigmoid, multiply (1, 2), min, exp minus one, max (3), add (5, 6), softplus, erf, "
                     "exp, log, min, multiply, max (11), add (13, 14)"},
        OnnxSpelling{"ShapesOfResults",
                     op("MatMul", {"x", "w"}, "a") + op("Shape", {"a"}, "s") +
                         op("Constant", {}, "zero", tensorAttribute("data_type: 7 int64_data: 0")) +
                         op("Gather", {"s", "zero"}, "n") +
                         op("Constant", {}, "axis", tensorAttribute("dims: 1 data_type: 7 int64_data: 0")) +
                         op("Unsqueeze", {"n", "axis"}, "n1") +
                         op("Constant", {}, "rest", tensorAttribute("dims: 1 data_type: 7 int64_data: -1")) +
                         op("Concat", {"n1", "rest"}, "shape", integerAttribute("axis", "0")) +
                         op("Reshape", {"a", "shape"}, "y"),
                     "10, matrix 2"},
        OnnxSpelling{
            "LayerNorm",
            op("MatMul", {"x", "w0"}, "a") +
                op("LayerNormalization", {"a", "b0", "b0"}, "c", realAttribute("epsilon", "0.001")) +
                op("MatMul", {"c", "w1"}, "y"),
            "10, matrix 24, sum 1, divide, pick 24, subtract (1, 4), multiply (5, 5), sum 1, divide, add, sqrt, "
            "pick 24, divide (5, 11), multiply, add, matrix 2",
            17},
        OnnxSpelling{
            "LayerNormDecomposed",
            op("MatMul", {"x", "w0"}, "a") +
                op("ReduceMean", {"a"}, "m", "attribute { name: 'axes' type: INTS ints: -1 }") +
                op("Sub", {"a", "m"}, "d") + op("Constant", {}, "two", tensorAttribute("data_type: 1 float_data: 2")) +
                op("Pow", {"d", "two"}, "e") +
                op("ReduceMean", {"e"}, "f", "attribute { name: 'axes' type: INTS ints: -1 }") +
                op("Add", {"f", "number"}, "g") + op("Sqrt", {"g"}, "h") + op("Div", {"d", "h"}, "i") +
                op("MatMul", {"i", "w1"}, "y"),
            "10, matrix 24, sum 1, divide, pick 24, subtract (1, 4), multiply (5, 5), sum 1, divide, add, sqrt, "
            "pick 24, divide (5, 11), matrix 2"},
        OnnxSpelling{"WhatMovesNothing",
                     op("Constant", {}, "s", tensorAttribute(kShapeOfRows)) + op("Reshape", {"x", "s"}, "a") +
                         op("Flatten", {"a"}, "c") + op("Identity", {"c"}, "d") +
                         op("Cast", {"d"}, "e", integerAttribute("to", "1")) +
                         op("Constant", {}, "off", tensorAttribute("data_type: 9 raw_data: '\\000'")) +
                         op("Dropout", {"e", "", "off"}, "f", "output: 'mask'") + op("MatMul", {"f", "w"}, "y"),
                     "10, matrix 2"}),
    [](const ::testing::TestParamInfo<OnnxSpelling>& info) { return std::string(info.param.name); });

/// Numbers are as written plainly, in this order of float32 operations.
TEST(OnnxGemm, MultipliesTheProductByAlphaAndTheBiasByBeta) {
  onnx::ModelProto model = onnxModel("");
  onnx::GraphProto& graph = *model.mutable_graph();
  graph.clear_initializer();
  const std::vector<float> matrix = {0.1F, 0.2F, 0.3F, 0.4F, 0.5F, 0.6F, 0.7F, 0.8F, 0.9F, 1.0F,
                                     1.1F, 1.2F, 1.3F, 1.4F, 1.5F, 1.6F, 1.7F, 1.8F, 1.9F, 2.0F};
  testing::addTensor(graph, "m", {2, 10}, matrix);
  testing::addTensor(graph, "c", {2}, {0.7F, -0.3F});
  onnx::GraphProto nodes;
  ASSERT_TRUE(google::protobuf::TextFormat::ParseFromString(
      op("Gemm", {"x", "m", "c"}, "y",
         realAttribute("alpha", "0.3") + realAttribute("beta", "1.7") + integerAttribute("transB", "1")),
      &nodes));
  *graph.mutable_node() = nodes.node();
  NetworkKernel kernel(10, readModel(model).operations);
  for (const Observation& row : testing::observations()) {
    Action action{};
    kernel.run(row, action);
    for (std::size_t column = 0; column < action.size(); ++column) {
      float sum = 0;
      for (std::size_t k = 0; k < row.size(); ++k) {
        sum += row[k] * matrix[column * row.size() + k];
      }
      EXPECT_EQ(action[column], sum * 0.3F + (column == 0 ? 0.7F : -0.3F) * 1.7F);
    }
  }
}

TEST(OnnxModel, SaysItsOpsetAndItsProducer) {
  const OnnxNetwork network = readModel(onnxModel(op("Gemm", {"x", "w", "b"}, "y"), 17));
  EXPECT_EQ(network.opset, 17);
  EXPECT_EQ(network.producer, "test 1");
}

/// Files of the first formats list initializers among the inputs.
TEST(OnnxModel, MayListItsInitializersAsInputs) {
  onnx::ModelProto model = onnxModel(op("Gemm", {"x", "w", "b"}, "y"));
  model.set_ir_version(3);
  model.mutable_graph()->add_input()->set_name("w");
  model.mutable_graph()->add_input()->set_name("b");
  EXPECT_EQ(operationsOf(model), "10, matrix 2, add");
}

// Refusals: each one line that names the thing and the rule.

void expectOnnxRefusal(const std::string& bytes, ExitCode exit_code, const std::string& part) {
  try {
    readOnnx(bytes);
    FAIL() << "accepted, though " << part;
  } catch (const Error& error) {
    EXPECT_EQ(error.exitCode(), exit_code) << error.what();
    EXPECT_THAT(error.what(), HasSubstr(part));
    EXPECT_THAT(error.what(), Not(HasSubstr("\n")));
  }
}

void expectOnnxRefusal(const onnx::ModelProto& model, ExitCode exit_code, const std::string& part) {
  expectOnnxRefusal(model.SerializeAsString(), exit_code, part);
}

struct UnfitNodes {
  std::string nodes;
  std::string part;
};

TEST(OnnxRefusal, NamesOperatorNodeAndWhatToDo) {
  expectOnnxRefusal(onnxModel(op("MatMul", {"x", "w"}, "a") + op("Softmax", {"a"}, "y")), ExitCode::kInvalidInput,
                    "operator 'Softmax' of node '/Softmax': is not known to the kernel; docs/networks.md says what "
                    "runs, and what to do");
  expectOnnxRefusal(
      onnxModel(op("Sin", {"x"}, "a") + op("Sin", {"a"}, "c") + op("Softmax", {"c"}, "d") +
                op("Gemm", {"x", "w"}, "e", integerAttribute("transA", "1")) + op("Add", {"d", "e"}, "y")),
      ExitCode::kInvalidInput,
      "operator 'Sin' of node '/Sin', operator 'Softmax' of node '/Softmax': are not known to the kernel; operator "
      "'Gemm' of node '/Gemm': its transA must be 0; docs/networks.md");
  expectOnnxRefusal(onnxModel("node { op_type: 'Gelu' domain: 'own' input: 'x' output: 'y' }"), ExitCode::kInvalidInput,
                    "operator 'own.Gelu' of node 0: is not known to the kernel");
  expectOnnxRefusal(onnxModel("node { op_type: 'A\\nB' name: 'n\\001' input: 'x' output: 'y' }"),
                    ExitCode::kInvalidInput, "operator 'A?B' of node 'n?'");
}

TEST(OnnxRefusal, OfNodesThatTheKernelCannotDo) {
  const std::string product = op("MatMul", {"x", "w"}, "a");
  for (const UnfitNodes& unfit : std::vector<UnfitNodes>{
           {product + op("Add", {"x", "b"}, "y"), "one for each of 10 columns"},
           {product + op("MatMul", {"a", "x"}, "y"), "'x' must be constant"},
           {op("MatMul", {"w_t", "x"}, "y"), "'x' must be constant"},
           {product + op("Add", {"a", "nothing"}, "y"), "'nothing' must be the result of an operation before it"},
           {op("MatMul", {"x", "w_t"}, "y"), "its matrix must be float32 for 10 inputs"},
           {op("MatMul", {"x", "b"}, "y"), "its matrix must be float32 for 10 inputs"},
           {op("Gemm", {"x", "w"}, "y", integerAttribute("transA", "1")), "its transA must be 0"},
           {op("Gemm", {"x", "w"}, "y", integerAttribute("alpha", "1")), "its alpha must be a finite number"},
           {op("Gemm", {"x", "w"}, "y", realAttribute("transB", "1")), "its transB must be an integer"},
           {op("Gemm", {"x", "w"}, "y", realAttribute("gamma", "1")), "its attribute 'gamma' is not known"},
           {op("Gemm", {"x"}, "y"), "must have 2 to 3 inputs and an output, but has 1 inputs"},
           {op("Add", {"x", "w_t"}, "a") + op("MatMul", {"a", "w"}, "y"), "one for each of 10 columns"},
           {op("Add", {"x", "b"}, "a") + op("MatMul", {"a", "w"}, "y"), "one for each of 10 columns"},
           {op("Constant", {}, "c", tensorAttribute("data_type: 7 int64_data: 2")) + op("Mul", {"x", "c"}, "y"),
            "its operand 'c' must be float32"},
           {op("Constant", {}, "c", "attribute { name: 'value_string' s: 'x' }"), "must be a tensor or numbers"},
           {op("Constant", {}, "c"), "must have one value"},
           {op("Clip", {"x"}, "y", realAttribute("min", "0")), "its bounds must be inputs in opset 14"},
           {op("Cast", {"x"}, "y", integerAttribute("to", "11")), "must keep float32"},
           {op("Flatten", {"x"}, "y", integerAttribute("axis", "0")), "must keep the rollouts apart"},
           {op("Reshape", {"x", "low"}, "y"), "'low' must be constant integers"},
           {op("Constant", {}, "s", tensorAttribute("dims: 2 data_type: 7 int64_data: [-1, 4]")) +
                op("Reshape", {"x", "s"}, "y"),
            "must keep the 10 numbers of a row"},
           {op("Transpose", {"w"}, "m", "attribute { name: 'perm' type: INTS ints: [0, 0] }"), "each dimension once"},
           {op("Pow", {"x", "number"}, "y"), "its exponent must be 0.5, 1, 2 or 3"},
           {op("ReduceMean", {"x"}, "y"), "its axes must be named, and not be the first, that of rollouts"},
           {op("BatchNormalization", {"x", "low", "low", "low", "low"}, "y", integerAttribute("training_mode", "1")),
            "must be in evaluation: call .eval() before exporting"},
           {op("Constant", {}, "on", tensorAttribute("data_type: 9 int32_data: 1")) +
                op("Dropout", {"x", "", "on"}, "y"),
            "must be off"},
           {op("MatMul", {"x", "w"}, "x"), "name 'x': must be given to one tensor"},
           {op("Identity", {"w"}, "b"), "name 'b': must be given to one tensor"},
           {product, "output 'y': must be the result of an operation, in float32"},
       }) {
    expectOnnxRefusal(onnxModel(unfit.nodes), ExitCode::kInvalidInput, unfit.part);
  }
}

TEST(OnnxRefusal, OfBytesThatAreNoModel) {
  const std::string whole = onnxModel(op("Gemm", {"x", "w", "b"}, "y")).SerializeAsString();
  expectOnnxRefusal("", ExitCode::kInvalidInput, "must be ONNX, but is empty");
  expectOnnxRefusal("PK\3\4...", ExitCode::kInvalidInput, "is a zip archive, as TorchScript is: name it .ts.pt");
  expectOnnxRefusal(whole.substr(0, whole.size() / 2), ExitCode::kInvalidInput, "must be ONNX: protobuf cannot read");
  expectOnnxRefusal(std::string(1000, '\xff'), ExitCode::kInvalidInput, "must be ONNX: protobuf cannot read it");
  expectOnnxRefusal(whole.substr(0, 2), ExitCode::kInvalidInput, "must be ONNX with a graph and ir_version 3 to 10");
}

using Change = std::function<void(onnx::ModelProto&)>;

struct ChangedModel {
  Change change;
  ExitCode exit_code;
  std::string part;
};

onnx::TensorProto& firstTensor(onnx::ModelProto& model) { return *model.mutable_graph()->mutable_initializer(0); }

auto& shapeOf(onnx::ValueInfoProto& value) { return *value.mutable_type()->mutable_tensor_type()->mutable_shape(); }

TEST(OnnxRefusal, OfModelsThatAreNotThisNetwork) {
  constexpr std::int64_t kHuge = std::numeric_limits<std::int64_t>::max();
  const auto input = [](onnx::ModelProto& m) -> onnx::ValueInfoProto& { return *m.mutable_graph()->mutable_input(0); };
  const auto output = [](onnx::ModelProto& m) -> onnx::ValueInfoProto& {
    return *m.mutable_graph()->mutable_output(0);
  };
  for (
      const auto& [change, exit_code, part] : std::vector<ChangedModel>{
          {[](auto& m) { m.set_ir_version(99); }, ExitCode::kInvalidInput, "ir_version 3 to 10, but has ir_version 99"},
          {[](auto& m) { m.mutable_opset_import(0)->set_version(6); }, ExitCode::kInvalidInput,
           "opset 6: must be from 7 to 22"},
          {[](auto& m) { m.mutable_opset_import(0)->set_version(23); }, ExitCode::kInvalidInput,
           "opset 23: must be from 7 to 22"},
          {[](auto& m) { m.clear_opset_import(); }, ExitCode::kInvalidInput, "must name one opset of ONNX"},
          {[](auto& m) { m.add_functions()->set_name("Relu"); }, ExitCode::kInvalidInput,
           "must have no functions of its own, but has 'Relu'"},
          {[](auto& m) { m.mutable_graph()->add_input()->set_name("state"); }, ExitCode::kBadDependency,
           "must have 1 input, as its description says (policy.json in its metadata; none: one), but has 2: 'x' "
           "FLOAT ['n', 10], 'state' no tensor"},
          {[&](auto& m) { *m.mutable_graph()->add_output() = output(m); }, ExitCode::kBadDependency,
           "must have 1 output, as its description says (policy.json in its metadata; none: one), but has 2: 'y' FLOAT "
           "['n', 2], 'y' FLOAT ['n', 2]"},
          {[&](auto& m) { shapeOf(input(m)).mutable_dim(1)->set_dim_value(8); }, ExitCode::kBadDependency,
           "input 'x': must be FLOAT [n, 10] or [1, 10], but is FLOAT ['n', 8]"},
          {[&](auto& m) { shapeOf(input(m)).mutable_dim(0)->set_dim_value(4); }, ExitCode::kBadDependency,
           "but is FLOAT [4, 10]"},
          {[&](auto& m) { shapeOf(input(m)).mutable_dim(0)->set_dim_value(-1); }, ExitCode::kBadDependency,
           "but is FLOAT [-1, 10]"},
          {[&](auto& m) { input(m).mutable_type()->mutable_tensor_type()->clear_shape(); }, ExitCode::kBadDependency,
           "but is FLOAT of any shape"},
          {[&](auto& m) { input(m).mutable_type()->mutable_tensor_type()->set_elem_type(11); },
           ExitCode::kBadDependency, "but is DOUBLE ['n', 10]"},
          {[&](auto& m) { input(m).clear_type(); }, ExitCode::kBadDependency, "but is no tensor"},
          {[&](auto& m) { shapeOf(output(m)).mutable_dim(1)->set_dim_value(3); }, ExitCode::kBadDependency,
           "output 'y': must be FLOAT [n, 2] or [1, 2], but is FLOAT ['n', 3]"},
          {[](auto& m) {
             m.mutable_graph()->mutable_node(0)->set_input(1, "w0");
             m.mutable_graph()->mutable_node(0)->set_input(2, "b0");
           },
           ExitCode::kBadDependency, "output 'y': must be [1, 2] for one rollout, but is [1, 24]"},
          {[&](auto& m) { firstTensor(m).set_dims(0, 268435456); }, ExitCode::kInvalidInput,
           "tensor 'w': must hold the values of its shape [268435456, 2], but holds 80 bytes"},
          {[&](auto& m) {
             firstTensor(m).set_dims(0, kHuge);
             firstTensor(m).set_dims(1, kHuge);
           },
           ExitCode::kInvalidInput, "tensor 'w': must hold the values of its shape"},
          {[&](auto& m) { firstTensor(m).set_dims(0, -10); }, ExitCode::kInvalidInput,
           "tensor 'w': its dimensions must not be negative, but are [-10, 2]"},
          {[&](auto& m) { firstTensor(m).mutable_raw_data()->push_back('\0'); }, ExitCode::kInvalidInput,
           "but holds 81 bytes"},
          {[&](auto& m) { firstTensor(m).clear_raw_data(); }, ExitCode::kInvalidInput, "but holds 0"},
          {[&](auto& m) { firstTensor(m).add_float_data(1.0F); }, ExitCode::kInvalidInput, "tensor 'w': must hold"},
          {[&](auto& m) { firstTensor(m).set_data_location(onnx::TensorProto::EXTERNAL); }, ExitCode::kInvalidInput,
           "tensor 'w': its values must be in the file itself or in one beside it (external data), not in ''"},
          {[&](auto& m) { firstTensor(m).mutable_segment()->set_begin(1); }, ExitCode::kInvalidInput,
           "tensor 'w': must be in one piece"},
          {[&](auto& m) {
             const float nan = std::numeric_limits<float>::quiet_NaN();
             firstTensor(m).mutable_raw_data()->replace(8, 4, reinterpret_cast<const char*>(&nan), 4);
           },
           ExitCode::kBadDependency, "tensor 'w': its values must be finite"},
      }) {
    onnx::ModelProto model = onnxModel(op("Gemm", {"x", "w", "b"}, "y"));
    change(model);
    expectOnnxRefusal(model, exit_code, part);
  }
}

/// A small file may multiply by one matrix many times.
TEST(OnnxRefusal, OfMoreNumbersThanANetworkMayHave) {
  constexpr int kWide = 2048;
  constexpr int kTimes = 17;  // of a matrix of 4 million numbers: more than 67 million
  std::string nodes = op("Gemm", {"x", "first"}, "h0");
  for (int i = 0; i < kTimes; ++i) {
    nodes += op("Gemm", {"h" + std::to_string(i), "square"}, "h" + std::to_string(i + 1));
  }
  onnx::ModelProto model = onnxModel(nodes);
  testing::addTensor(*model.mutable_graph(), "first", {10, kWide}, std::vector<float>(10 * kWide, 0.1F));
  testing::addTensor(*model.mutable_graph(), "square", {kWide, kWide}, std::vector<float>(kWide * kWide, 0.1F));
  expectOnnxRefusal(model, ExitCode::kInvalidInput, "the network must have at most 67108864 numbers");
}

}  // namespace
}  // namespace pusht
