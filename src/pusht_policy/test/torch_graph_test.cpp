// SPDX-License-Identifier: BSD-3-Clause
// Which spellings of a network are recognized, and as what.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <ostream>
#include <string>
#include <vector>

#include "libtorch_testing.hpp"
#include "network_testing.hpp"
#include "pusht_policy/network_policy.hpp"

namespace pusht {
namespace {

using testing::bits;

struct Spelling {
  const char* name;
  const char* body;      ///< of forward(self, x)
  const char* expected;  ///< what the kernel is to do, or why it is not to be used
};

std::ostream& operator<<(std::ostream& stream, const Spelling& spelling) { return stream << spelling.name; }

std::string spellingName(const ::testing::TestParamInfo<Spelling>& info) { return info.param.name; }

/// A module with weights and buffers for all spellings; nn.Linear's weights are [outputs, inputs].
torch::jit::Module makeModule(const std::string& body) {
  constexpr int kHidden = 24;
  NumpyGenerator generator(11);
  const auto random = [&](at::IntArrayRef sizes, double low, double high) {
    torch::Tensor tensor = torch::empty(sizes);
    std::generate_n(tensor.data_ptr<float>(), tensor.numel(),
                    [&] { return static_cast<float>(generator.uniform(low, high)); });
    return tensor;
  };
  torch::jit::Module module("Policy");
  const std::vector<std::pair<std::string, std::vector<std::int64_t>>> parameters = {
      {"w", {2, 10}},
      {"b", {2}},  // a network without hidden layers
      {"w0", {kHidden, 10}},
      {"b0", {kHidden}},  // the first of several layers
      {"w1", {kHidden, kHidden}},
      {"b1", {kHidden}},  // any between
      {"w2", {2, kHidden}},
      {"b2", {2}},  // the last
      {"m", {10, 2}},
      {"row", {1, 2}},  // a matrix as it is multiplied, a bias as a row
  };
  for (const auto& [name, sizes] : parameters) {
    module.register_parameter(name, random(sizes, -0.3, 0.3), false);
  }
  module.register_buffer("obs_min", random({10}, -1.0, -0.5));
  module.register_buffer("obs_range", random({10}, 1.0, 2.0));
  module.register_buffer("act_min", random({2}, -1.0, -0.5));
  module.register_buffer("act_range", random({2}, 1.0, 2.0));
  module.register_buffer("two", torch::tensor(2.0F));
  module.register_buffer("two_double", torch::tensor(2.0, torch::kFloat64));
  module.register_buffer("ten_double", torch::ones({10}, torch::kFloat64));
  module.define("def forward(self, x):\n" + body);
  return module;
}

class NetworkSpelling : public ::testing::TestWithParam<Spelling> {
 protected:
  void SetUp() override {
    module_ = makeModule(GetParam().body);
    module_.save((folder_ / "policy.pt").string());
    policy_ = NetworkPolicy::load(folder_ / "policy.pt");
    actual_ = testing::flatten(testing::act(*policy_, testing::observations()));
    expected_ = testing::onLibtorch([&](const torch::Tensor& row) { return module_.forward({row}).toTensor(); },
                                    testing::flatten(testing::observations()), std::tuple_size<Observation>::value);
  }

  testing::TemporaryFolder folder_;
  torch::jit::Module module_;
  std::unique_ptr<NetworkPolicy> policy_;
  std::vector<float> actual_;
  std::vector<float> expected_;
};

// The kernel sums as libtorch on the reference BLAS does where layers are written as nn.Linear has them, and rounds
// as libtorch does everywhere but in tanh.

class NetworkSpelledToTheLastBit : public NetworkSpelling {};

TEST_P(NetworkSpelledToTheLastBit, RunsOnTheKernel) {
  EXPECT_EQ(policy_->info().why_not_on_kernel, "");
  EXPECT_EQ(policy_->info().operations, GetParam().expected);
  testing::expectNear(actual_, expected_, 1e-5F);
  if (testing::onReferenceBlas()) {
    EXPECT_EQ(bits(actual_), bits(expected_));
  }
}

INSTANTIATE_TEST_SUITE_P(
    , NetworkSpelledToTheLastBit,
    ::testing::Values(
        Spelling{"Course",
                 "  x = (x - self.obs_min) * 2 / self.obs_range - 1\n"
                 "  x = torch.relu(torch.linear(torch.clamp(x, -1.0, 1.0), self.w0, self.b0))\n"
                 "  x = torch.relu(torch.linear(x, self.w1, self.b1))\n"
                 "  y = torch.linear(x, self.w2, self.b2)\n"
                 "  return (y + 1) / 2 * self.act_range + self.act_min\n",
                 "10, subtract, multiply, divide, subtract, max, min, matrix 24, add, max, matrix 24, add, max, "
                 "matrix 2, add, add, divide, multiply, add"},
        Spelling{"FloatNumbersAndMethods",
                 "  x = (x - self.obs_min) * 2.0 / self.obs_range - 1.0\n"
                 "  x = torch.linear(x.clamp(-1, 1), self.w0, self.b0).relu()\n"
                 "  x = torch.linear(x, self.w1, self.b1).relu()\n"
                 "  y = torch.linear(x, self.w2, self.b2)\n"
                 "  return (y + 1.0) / 2.0 * self.act_range + self.act_min\n",
                 "10, subtract, multiply, divide, subtract, max, min, matrix 24, add, max, matrix 24, add, max, "
                 "matrix 2, add, add, divide, multiply, add"},
        Spelling{"NumbersFirst",
                 "  x = -1 + 2 * (x - self.obs_min) / self.obs_range\n"
                 "  x = torch.relu(torch.linear(x, self.w0, self.b0))\n"
                 "  y = torch.linear(x, self.w2, self.b2)\n"
                 "  return self.act_min + self.act_range * (0.5 * (1 + y))\n",
                 "10, subtract, multiply, divide, add, matrix 24, add, max, matrix 2, add, add, multiply, multiply, "
                 "add"},
        Spelling{"ZeroDimensionalTensors",
                 "  x = torch.linear(x * self.two, self.w, self.b)\n"
                 "  return x / self.two_double\n",
                 "10, multiply, matrix 2, add, divide"},
        Spelling{"InPlace",
                 "  x = (x - self.obs_min).mul_(2).div_(self.obs_range).sub_(1).clamp_(-1, 1)\n"
                 "  x = torch.linear(x, self.w0, self.b0).relu_()\n"
                 "  return torch.linear(x, self.w2, self.b2).add_(self.act_min)\n",
                 "10, subtract, multiply, divide, subtract, max, min, matrix 24, add, max, matrix 2, add, add"},
        Spelling{"NoHiddenLayer", "  return torch.linear(x, self.w, self.b)\n", "10, matrix 2, add"},
        Spelling{"NoBias", "  return torch.linear(torch.linear(x, self.w0), self.w2)\n", "10, matrix 24, matrix 2"},
        Spelling{"OneHiddenLayerWithoutBuffers",
                 "  return torch.linear(torch.relu(torch.linear(x, self.w0, self.b0)), self.w2, self.b2)\n",
                 "10, matrix 24, add, max, matrix 2, add"},
        Spelling{"FourHiddenLayers",
                 "  x = torch.relu(torch.linear(x, self.w0, self.b0))\n"
                 "  for i in range(3):\n"
                 "    x = torch.relu(torch.linear(x, self.w1, self.b1))\n"
                 "  return torch.linear(x, self.w2, self.b2)\n",
                 "10, matrix 24, add, max, matrix 24, add, max, matrix 24, add, max, matrix 24, add, max, matrix 2, "
                 "add"},
        Spelling{"ClampMinIsReLU",
                 "  x = torch.clamp_min(torch.linear(x, self.w0, self.b0), 0)\n"
                 "  x = torch.linear(x, self.w1, self.b1).clamp(min=0.0)\n"
                 "  return torch.linear(x, self.w2, self.b2).clamp_max(0.5)\n",
                 "10, matrix 24, add, max, matrix 24, add, max, matrix 2, add, min"},
        Spelling{"ClampToTensors",
                 "  return torch.clamp(torch.linear(x, self.w, self.b), self.act_min, self.act_range)\n",
                 "10, matrix 2, add, max, min"},
        Spelling{"ClampWithCrossedBounds", "  return torch.clamp(torch.linear(x, self.w, self.b), 0.25, -0.25)\n",
                 "10, matrix 2, add, max, min"},
        Spelling{"HardtanhAndReLU6",
                 "  x = torch.relu6(torch.linear(x, self.w0, self.b0))\n"
                 "  return torch.hardtanh(torch.linear(x, self.w2, self.b2), -0.5, 0.25)\n",
                 "10, matrix 24, add, max, min, matrix 2, add, max, min"},
        Spelling{"NegatedAndSubtractedFrom",
                 "  x = torch.neg(1 - x)\n"
                 "  x = torch.rsub(x, 0.5)\n"
                 "  return self.act_min - torch.linear(x, self.w, self.b)\n",
                 "10, multiply, add, multiply, multiply, add, matrix 2, add, multiply, add"},
        Spelling{"MatrixFromTheRight", "  return torch.matmul(x, self.m) + self.row\n", "10, matrix 2, add"},
        Spelling{"TransposedMatrix", "  return x @ self.w.t() + self.b\n", "10, matrix 2, add"},
        Spelling{"AddmmOfATransposedMatrix", "  return torch.addmm(self.b, x, self.w.t())\n", "10, matrix 2, add"},
        Spelling{"CopiesAndCasts",
                 "  x = x.to(6).contiguous().detach()\n"
                 "  return torch.dropout(torch.linear(x, self.w, self.b), 0.5, False).clone().float()\n",
                 "10, matrix 2, add"},
        Spelling{"BranchOnTheShape",
                 "  if x.dim() == 1:\n"
                 "    x = x.unsqueeze(0)\n"
                 "  return torch.linear(x, self.w, self.b)\n",
                 "10, matrix 2, add"}),
    spellingName);

class NetworkSpelledAlmostToTheLastBit : public NetworkSpelling {};

TEST_P(NetworkSpelledAlmostToTheLastBit, RunsOnTheKernel) {
  EXPECT_EQ(policy_->info().why_not_on_kernel, "");
  EXPECT_EQ(policy_->info().operations, GetParam().expected);
  testing::expectNear(actual_, expected_, 2e-6F);
}

INSTANTIATE_TEST_SUITE_P(
    , NetworkSpelledAlmostToTheLastBit,
    ::testing::Values(Spelling{"TanhAtTheEnd",
                               "  x = torch.relu(torch.linear(x, self.w0, self.b0))\n"
                               "  return torch.tanh(torch.linear(x, self.w2, self.b2))\n",
                               "10, matrix 24, add, max, matrix 2, add, tanh"},
                      Spelling{"TanhBetween",
                               "  x = torch.linear(x, self.w0, self.b0).tanh()\n"
                               "  x = torch.linear(x, self.w1, self.b1).tanh_()\n"
                               "  return torch.linear(x, self.w2, self.b2)\n",
                               "10, matrix 24, add, tanh, matrix 24, add, tanh, matrix 2, add"},
                      Spelling{
                          "AddmmWithTheBiasFirst",  // which is how libtorch sums for a matrix that is not transposed
                          "  return torch.addmm(self.b, x, self.m)\n", "10, matrix 2, add"}),
    spellingName);

// Networks of several paths, and functions of the kernel's own.

const char* const kHidden = "10, matrix 24, add, ";

std::string withFunction(const std::string& function) {
  return "  h = " + function + "(torch.linear(x, self.w0, self.b0))\n  return torch.linear(h, self.w2, self.b2)\n";
}

struct Graph {
  const char* name;
  std::string body;
  std::string expected;  ///< end of the kernel's operations
};

std::ostream& operator<<(std::ostream& stream, const Graph& graph) { return stream << graph.name; }

class NetworkGraph : public ::testing::TestWithParam<Graph> {};

TEST_P(NetworkGraph, RunsOnTheKernel) {
  const testing::TemporaryFolder folder;
  torch::jit::Module module = makeModule(GetParam().body);
  module.save((folder / "policy.pt").string());
  const std::vector<float> expected =
      testing::onLibtorch([&](const torch::Tensor& row) { return module.forward({row}).toTensor(); },
                          testing::flatten(testing::manyObservations()), std::tuple_size<Observation>::value);
  std::vector<float> baseline;
  for (const InstructionSet instruction_set : {InstructionSet::kBaseline, availableInstructionSets().back()}) {
    const auto policy = NetworkPolicy::load(folder / "policy.pt", instruction_set);
    ASSERT_EQ(policy->info().why_not_on_kernel, "");
    EXPECT_THAT(policy->info().operations, ::testing::EndsWith(GetParam().expected));
    const std::vector<float> actual = testing::flatten(testing::act(*policy, testing::manyObservations(), 7));
    testing::expectNear(actual, expected, 1e-5F);
    baseline = baseline.empty() ? actual : baseline;
    EXPECT_EQ(bits(actual), bits(baseline)) << toString(instruction_set);
  }
}

INSTANTIATE_TEST_SUITE_P(
    , NetworkGraph,
    ::testing::Values(
        Graph{"SameRowsTwice", "  x = torch.linear(x, self.w, self.b)\n  return x * x\n",
              "10, matrix 2, add, multiply (2, 2)"},
        Graph{"EarlierRows",
              "  h = torch.relu(torch.linear(x, self.w0, self.b0))\n"
              "  return torch.linear(h, self.w2, self.b2) + torch.linear(x, self.w, self.b)\n",
              "matrix 2, add, matrix 2 (0), add, add (5, 7)"},
        Graph{"Residual",
              "  h = torch.linear(x, self.w0, self.b0)\n"
              "  h = h + torch.relu(torch.linear(h, self.w1, self.b1))\n"
              "  return torch.linear(h, self.w2, self.b2)\n",
              "matrix 24, add, max, add (2, 5), matrix 2, add"},
        Graph{"SlicesAndCat",
              "  a, b = torch.linear(x, self.w0, self.b0).chunk(2, -1)\n"
              "  c = torch.cat([b.tanh(), a, x[:, 2:8:2], x[:, :1], torch.stack([a[:, 3], b[:, 4]], 1)], 1)\n"
              "  return c[:, :2] - c[..., -2:] + c.split([20, 10], 1)[1][:, :2]\n",
              "pick 30 (5, 3, 6, 7, 10), pick 2, pick 2 (11), subtract (12, 13), pick 10 (11), pick 2, add (14, 16)"},
        Graph{"ReadAfterItWasChanged",
              "  y = torch.linear(x, self.w, self.b)\n"
              "  z = y.relu_()\n"
              "  return y\n",
              "10, matrix 2, add, max"},
        Graph{"ChangedInPlace",
              "  h = torch.linear(x, self.w0, self.b0)\n"
              "  y = torch.linear(h, self.w1, self.b1)\n"
              "  y.relu_()\n"
              "  y = y.add_(h)\n"
              "  return torch.linear(y, self.w2, self.b2)\n",
              "max, add (5, 2), matrix 2, add"},
        Graph{"Quotient", "  return 1.0 / (2.0 + torch.relu(torch.linear(x, self.w, self.b)))\n",
              "constant 2, divide (5, 4), multiply"},
        Graph{"Elu", withFunction("torch.elu"), "min, exp minus one, max (2), add (4, 5), matrix 2, add"},
        Graph{"Selu", withFunction("torch.selu"), "multiply, matrix 2, add"},
        Graph{"Celu", withFunction("torch.celu"), "add (4, 5), matrix 2, add"},
        Graph{"Sigmoid", withFunction("torch.sigmoid"), std::string(kHidden) + "sigmoid, matrix 2, add"},
        Graph{"Swish", "  h = torch.linear(x, self.w0, self.b0)\n  return torch.linear(h * h.sigmoid(), self.w2)\n",
              std::string(kHidden) + "sigmoid, multiply (2, 3), matrix 2"},
        Graph{"Silu", withFunction("torch.silu"), std::string(kHidden) + "sigmoid, multiply (2, 3), matrix 2, add"},
        Graph{"Gelu", withFunction("torch.gelu"), "divide, erf, add, multiply (2, 5), multiply, matrix 2, add"},
        Graph{"GeluByTanh",
              "  h = torch.gelu(torch.linear(x, self.w0, self.b0), approximate='tanh')\n"
              "  return torch.linear(h, self.w2, self.b2)\n",
              "tanh, add, multiply (2), multiply (10, 9), matrix 2, add"},
        Graph{"LeakyRelu", "  return torch.leaky_relu(torch.linear(x, self.w), 0.2)\n",
              "10, matrix 2, min, multiply, max (1), add (3, 4)"},
        Graph{"Softplus", withFunction("torch.softplus"), std::string(kHidden) + "softplus, matrix 2, add"},
        Graph{"Mish", withFunction("torch.mish"),
              std::string(kHidden) + "softplus, tanh, multiply (2, 4), matrix 2, add"},
        Graph{"HardSwish", withFunction("torch.hardswish"),
              std::string(kHidden) + "multiply, add, max, min, multiply (2, 6), matrix 2, add"},
        Graph{"HardSigmoid", withFunction("torch.hardsigmoid"),
              std::string(kHidden) + "multiply, add, max, min, matrix 2, add"},
        Graph{"ExpLogSqrtAbsErf",
              "  h = torch.exp(torch.linear(x, self.w))\n"
              "  return torch.log(h + 1.0) + torch.sqrt(torch.abs(h)) * torch.erf(h) - torch.expm1(h).pow(2) / 1e4\n",
              "divide, subtract (10, 13)"},
        Graph{"LayerNorm",
              "  h = torch.layer_norm(torch.linear(x, self.w0, self.b0), [24], self.b0, self.b1, 1e-5)\n"
              "  return torch.linear(h, self.w2, self.b2)\n",
              "add, sqrt, pick 24, divide (6, 12), multiply, add, matrix 2, add"},
        Graph{"BatchNorm",
              "  h = torch.batch_norm(torch.linear(x, self.w0), self.b0, self.b1, self.b0, self.b1.abs(), False, 0.1,"
              " 1e-5, False)\n  return torch.linear(h, self.w2, self.b2)\n",
              "10, matrix 24, subtract, divide, multiply, add, matrix 2, add"},
        Graph{"MeanOfColumns",
              "  h = torch.linear(x, self.w0, self.b0)\n"
              "  h = (h - h.mean(dim=1, keepdim=True)) / (1.0 + h.sum(1).unsqueeze(1).abs())\n"
              "  return torch.linear(h, self.w2, self.b2)\n",
              "matrix 2, add"},
        Graph{"ListThatGrows",
              "  heads = [torch.linear(x, self.w, self.b)]\n"
              "  for i in range(2):\n"
              "    heads.append(torch.linear(x, self.w * float(i + 1), self.b))\n"
              "  return torch.stack(heads, 0).mean(0) + torch.glu(x[:, [0, 7, 8, 3]], -1)\n",
              "sigmoid, multiply (10, 12), add (8, 13)"},
        Graph{"RowsAsMatrices",
              "  h = torch.tanh(torch.matmul(x.view(1, 5, 2), self.w))\n"
              "  return h.transpose(1, 2).flatten(1)[:, 8:10]\n",
              "pick 2"}),
    [](const ::testing::TestParamInfo<Graph>& info) { return std::string(info.param.name); });

// What the kernel does not know, or must not do, is left to libtorch; there a row must not depend on its batch either.

class NetworkLeftToLibtorch : public NetworkSpelling {};

TEST_P(NetworkLeftToLibtorch, GivesItsBitsForEveryBatch) {
  EXPECT_THAT(policy_->info().why_not_on_kernel, ::testing::HasSubstr(GetParam().expected));
  EXPECT_FALSE(policy_->info().runsOnKernel());
  EXPECT_EQ(policy_->info().operations, "");
  EXPECT_EQ(policy_->info().instruction_set, "");
  EXPECT_EQ(bits(actual_), bits(expected_));
  for (const std::size_t batch : {2, 7, 50}) {
    EXPECT_EQ(bits(testing::flatten(testing::act(*policy_, testing::observations(), batch))), bits(expected_));
  }
}

INSTANTIATE_TEST_SUITE_P(
    , NetworkLeftToLibtorch,
    ::testing::Values(
        Spelling{"PartReadAfterTheWholeWasChanged",
                 "  y = torch.linear(x, self.w0, self.b0)\n"
                 "  z = y[:, :2]\n"
                 "  y = y.relu_()\n"
                 "  return z\n",
                 "must not take a tensor that an operation in place has changed since"},
        Spelling{"AllThatIsNotKnown",
                 "  y = torch.sin(torch.linear(x, self.w, self.b))\n"
                 "  z = torch.cos(y) + torch.cos(torch.linear(x, self.w))\n"
                 "  return torch.add(torch.linear(x, self.w), self.act_min, alpha=2) + z\n",
                 "aten::sin, aten::cos: are not known to the kernel; aten::add: its alpha must be 1"},
        Spelling{"SoftplusWithALowThreshold", "  return torch.softplus(torch.linear(x, self.w, self.b), 1, 2)\n",
                 "aten::softplus: its threshold must be at least 15"},
        Spelling{"ScaledAdd", "  return torch.add(torch.linear(x, self.w, self.b), self.act_min, alpha=2)\n",
                 "aten::add: its alpha must be 1"},
        Spelling{"ScaledAddmm", "  return torch.addmm(self.b, x, self.m, beta=0.5, alpha=2.0)\n",
                 "aten::addmm: its beta must be 1"},
        Spelling{"RoundedQuotient",
                 "  return torch.div(torch.linear(x, self.w, self.b), 0.125, rounding_mode='floor')\n",
                 "aten::div: must not round"},
        Spelling{"DoubleAndBack", "  return torch.linear(x.double().float(), self.w, self.b)\n",
                 "aten::to: must keep float32"},
        Spelling{"DoubleOperand", "  return torch.linear((x + self.ten_double).float(), self.w, self.b)\n",
                 "aten::add: its operand must be float32"},
        Spelling{"BranchOnTheNumbers",
                 "  y = torch.linear(x, self.w, self.b)\n"
                 "  if bool(y[0, 0] > 0.0):\n"
                 "    y = y + 1.0\n"
                 "  return y\n",
                 "aten::gt: is not known to the kernel"},
        Spelling{"Rows", "  return torch.linear(x, self.w, self.b).sum(0, keepdim=True)\n",
                 "aten::sum: must not be along the first axis"}),
    spellingName);

}  // namespace
}  // namespace pusht
