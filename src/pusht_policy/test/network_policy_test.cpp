// SPDX-License-Identifier: BSD-3-Clause
#include "pusht_policy/network_policy.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <new>
#include <string>
#include <vector>

#include "../src/torch_network.hpp"
#include "libtorch_testing.hpp"
#include "network_testing.hpp"
#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"

namespace {
std::atomic<int> allocations{0};
}  // namespace

// Counted, so that a test can say that nothing is allocated; not inlined, or the compiler warns of new beside free.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size)) {
    return memory;
  }
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace pusht {
namespace {

namespace fs = std::filesystem;
using testing::act;
using testing::bits;
using testing::flatten;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::observations;

/// Loading `path` must fail so, with a message of one line that holds all of `parts`.
void expectRefusal(const fs::path& path, ExitCode exit_code, const std::vector<std::string>& parts) {
  try {
    NetworkPolicy::load(path);
    FAIL() << path << " is accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.exitCode(), exit_code) << error.what();
    EXPECT_THAT(error.what(), Not(HasSubstr("\n")));
    for (const std::string& part : parts) {
      EXPECT_THAT(error.what(), HasSubstr(part));
    }
  }
}

/// Whether a row's action is, to the last bit, the same alone and in batches.
void expectRowsNotToDependOnTheBatch(Policy& policy) {
  const std::vector<Action> alone = act(policy, observations());
  for (const std::size_t batch : {2, 3, 5, 6, 7, 8, 16, 33, 50}) {
    EXPECT_EQ(bits(flatten(act(policy, observations(), batch))), bits(flatten(alone))) << "batches of " << batch;
  }
}

/// What libtorch makes of the observations.
std::vector<float> onLibtorch(const fs::path& path, const std::vector<Observation>& rows = observations()) {
  torch::jit::Module module = torch::jit::load(path.string());
  module.eval();
  return testing::onLibtorch([&](const torch::Tensor& row) { return module.forward({row}).toTensor(); }, flatten(rows),
                             std::tuple_size<Observation>::value);
}

class NetworkCheckpoint : public ::testing::Test {
 protected:
  /// A checkpoint with parameter w [outputs, inputs], buffer b [outputs] and this forward.
  void write(const std::string& body, int inputs = 10, int outputs = 2, float bias = 0.0F,
             torch::ScalarType type = torch::kFloat32) const {
    torch::manual_seed(1);
    torch::jit::Module module("Policy");
    module.register_parameter("w", torch::rand({outputs, inputs}).to(type) - 0.5, false);
    module.register_buffer("b", torch::full({outputs}, bias, type));
    module.define("def forward(self, x):\n  " + body + "\n");
    module.save(checkpoint_.string());
  }

  const testing::TemporaryFolder folder_;
  const fs::path checkpoint_ = folder_ / "policy.ts.pt";
  const fs::path provenance_ = folder_ / "policy.ts.pt.provenance.json";
};

const char* const kLinear = "return torch.linear(x, self.w, self.b)";
const char* const kCosine = "return torch.cos(torch.linear(x, self.w, self.b))";  // not on the kernel

TEST_F(NetworkCheckpoint, SaysWhereItsNumbersComeFrom) {
  write(kLinear);
  const auto policy = NetworkPolicy::load(checkpoint_);
  EXPECT_EQ(policy->info().sha256, sha256(readFile(checkpoint_, "policy")));
  EXPECT_EQ(policy->info().operations, "10, matrix 2, add");
  EXPECT_EQ(policy->info().instruction_set, toString(availableInstructionSets().back()));
  EXPECT_THAT(policy->info().libtorch_version, HasSubstr("."));
  EXPECT_TRUE(fs::is_regular_file(policy->info().blas)) << policy->info().blas;
}

TEST_F(NetworkCheckpoint, GivesARowTheSameBitsInAnyBatch) {
  write(kLinear);
  expectRowsNotToDependOnTheBatch(*NetworkPolicy::load(checkpoint_));
  write(kCosine);
  expectRowsNotToDependOnTheBatch(*NetworkPolicy::load(checkpoint_));
}

TEST_F(NetworkCheckpoint, GivesActionsThatAreNeitherClippedNorMadeFinite) {
  write(kLinear, 10, 2, 7.0F);
  const auto policy = NetworkPolicy::load(checkpoint_);
  std::vector<Observation> rows(3);
  rows[1][4] = std::numeric_limits<float>::infinity();
  const std::vector<Action> actions = act(*policy, rows, rows.size());
  EXPECT_EQ(actions[0], (Action{7.0F, 7.0F}));
  EXPECT_FALSE(isFinite(actions[1]));
  EXPECT_EQ(actions[2], (Action{7.0F, 7.0F}));
}

TEST_F(NetworkCheckpoint, ActsWithoutAllocating) {
  const auto policy = NetworkPolicy::untrained(0);
  const std::vector<Policy::Query> queries(33);
  std::vector<Action> actions(queries.size());
  policy->act(queries, actions);
  const int before = allocations;
  policy->act(queries, actions);
  policy->act({queries.data(), 5}, {actions.data(), 5});
  EXPECT_EQ(allocations, before);
}

TEST_F(NetworkCheckpoint, MustBeAReadableFile) {
  expectRefusal(checkpoint_, ExitCode::kInvalidInput, {"policy " + checkpoint_.string(), "must be a readable file"});
  expectRefusal(checkpoint_.parent_path(), ExitCode::kInvalidInput, {"must be a readable file"});
}

TEST_F(NetworkCheckpoint, MustBeTorchScript) {
  write(kLinear);
  const std::string whole = readFile(checkpoint_, "policy");
  std::string noise;
  for (int i = 0; i < 4096; ++i) {
    noise += static_cast<char>(i * 131 >> 3);
  }
  for (const std::string& content : {std::string(), whole.substr(0, whole.size() / 2), whole.substr(1), noise}) {
    writeFile(checkpoint_, content);
    expectRefusal(checkpoint_, ExitCode::kInvalidInput, {checkpoint_.string(), "must be TorchScript"});
  }
}

TEST_F(NetworkCheckpoint, MustBeTheOneThatItsProvenanceNames) {
  write(kLinear);
  const std::string hash = sha256(readFile(checkpoint_, "policy"));
  writeFile(provenance_, R"({"checkpoint": {"sha256": ")" + hash + R"("}})");
  EXPECT_NO_THROW(NetworkPolicy::load(checkpoint_));

  writeFile(checkpoint_, "no TorchScript: libtorch must not see it");
  const std::string other_hash = sha256("no TorchScript: libtorch must not see it");
  expectRefusal(checkpoint_, ExitCode::kBadDependency, {checkpoint_.string(), provenance_.string(), hash, other_hash});
}

TEST_F(NetworkCheckpoint, NamesABrokenProvenanceFile) {
  write(kLinear);
  for (const char* content : {"", "{", "[]", "{}", R"({"checkpoint": {}})", R"({"checkpoint": {"sha256": 1}})",
                              R"({"checkpoint": {"sha256": "a\nb"}})"}) {
    writeFile(provenance_, content);
    expectRefusal(checkpoint_, ExitCode::kInvalidInput, {"provenance " + provenance_.string(), "checkpoint.sha256"});
  }
}

TEST_F(NetworkCheckpoint, ProvenanceOfAnotherFormatIsRefused) {
  write(kLinear);
  const std::string rest = R"(, "checkpoint": {"sha256": ")" + sha256(readFile(checkpoint_, "policy")) + R"("}})";
  writeFile(provenance_, R"({"format": 1)" + rest);
  EXPECT_NO_THROW(NetworkPolicy::load(checkpoint_));
  for (const std::string format : {"2", "null"}) {
    writeFile(provenance_, R"({"format": )" + format + rest);
    expectRefusal(checkpoint_, ExitCode::kInvalidInput, {provenance_.string(), "format is " + format + ", must be 1"});
  }
}

TEST_F(NetworkCheckpoint, MustHaveFiniteNumbers) {
  write(kLinear, 10, 2, std::numeric_limits<float>::quiet_NaN());
  expectRefusal(checkpoint_, ExitCode::kBadDependency, {checkpoint_.string(), "b must be finite"});
  write("return torch.linear(x, self.w, self.b) * 1e38 * 1e38");
  expectRefusal(checkpoint_, ExitCode::kBadDependency, {"its actions must be finite"});
}

TEST_F(NetworkCheckpoint, MustMapAnObservationToAnAction) {
  write(kLinear, 12, 2);
  expectRefusal(checkpoint_, ExitCode::kBadDependency, {"float [1, 10]", "(1x10 and 12x2)"});
  write(kLinear, 10, 3);
  expectRefusal(checkpoint_, ExitCode::kBadDependency, {"float [1, 2]", "float [1, 3]"});
  write("return torch.linear(x, self.w, self.b)[0]");
  expectRefusal(checkpoint_, ExitCode::kBadDependency, {"float [1, 2]", "float [2]"});
  write("return torch.linear(x, self.w, self.b).unsqueeze(2)");
  expectRefusal(checkpoint_, ExitCode::kBadDependency, {"float [1, 2]", "float [1, 2, 1]"});
  write("return torch.linear(x, self.w, self.b), x");
  expectRefusal(checkpoint_, ExitCode::kBadDependency, {"float [1, 2]", "Tuple"});
  write("return torch.linear(x.double(), self.w, self.b)", 10, 2, 0.0F, torch::kFloat64);
  expectRefusal(checkpoint_, ExitCode::kBadDependency, {"float [1, 2]", "double [1, 2]"});
}

TEST_F(NetworkCheckpoint, MustNotFail) {
  write("return x + torch.ones([7])");
  expectRefusal(checkpoint_, ExitCode::kBadDependency, {checkpoint_.string(), "but fails: "});
}

/// What Python programs write.
class NetworkFromPython : public ::testing::Test {
 protected:
  const testing::TemporaryFolder& folder_ = testing::checkpointsFromPython();
};

TEST_F(NetworkFromPython, RunsOnTheKernelScriptedAndTraced) {
  for (const std::string name : {"course", "single_rows", "extras"}) {
    const auto scripted = NetworkPolicy::load(folder_ / (name + "_scripted.pt"));
    const auto traced = NetworkPolicy::load(folder_ / (name + "_traced.pt"));
    EXPECT_EQ(scripted->info().why_not_on_kernel, "") << name;
    EXPECT_EQ(traced->info().why_not_on_kernel, "") << name;
    const std::vector<float> actual = flatten(act(*scripted, observations()));
    EXPECT_EQ(bits(actual), bits(flatten(act(*traced, observations())))) << name;
    const std::vector<float> expected = onLibtorch(folder_ / (name + "_scripted.pt"));
    testing::expectNear(actual, expected, 1e-5F);
    if (testing::onReferenceBlas() && name != "extras") {  // which ends in a tanh
      EXPECT_EQ(bits(actual), bits(expected)) << name;
    }
  }
  const auto frozen = NetworkPolicy::load(folder_ / "course_frozen.pt");
  EXPECT_EQ(frozen->info().operations,
            "10, subtract, multiply, divide, subtract, max, min, matrix 48, add, max, matrix 48, add, max, matrix 2, "
            "add, add, divide, multiply, add");
}

TEST_F(NetworkFromPython, RunsOnLibtorchIfTheKernelHasNotItsOperations) {
  for (const char* name : {"cosine_scripted.pt", "cosine_traced.pt"}) {
    const auto policy = NetworkPolicy::load(folder_ / name);
    EXPECT_EQ(policy->info().why_not_on_kernel, "aten::cos: is not known to the kernel") << name;
    EXPECT_EQ(bits(flatten(act(*policy, observations()))), bits(onLibtorch(folder_ / name))) << name;
  }
}

TEST_F(NetworkFromPython, RunsOnTheKernelWithTheLayersThatPeopleTrain) {
  for (const std::string name :
       {"residual", "layer_norm", "batch_norm", "gelu", "gelu_tanh", "elu", "silu", "mish", "selu", "softplus",
        "leaky_relu", "prelu", "hardswish", "hardsigmoid", "gated", "two_heads"}) {
    const auto scripted = NetworkPolicy::load(folder_ / (name + "_scripted.pt"));
    const auto traced = NetworkPolicy::load(folder_ / (name + "_traced.pt"));
    EXPECT_EQ(scripted->info().why_not_on_kernel, "") << name;
    EXPECT_EQ(traced->info().why_not_on_kernel, "") << name;
    const std::vector<float> actual = flatten(act(*scripted, testing::manyObservations(), 50));
    testing::expectNear(actual, onLibtorch(folder_ / (name + "_scripted.pt"), testing::manyObservations()), 1e-5F);
    EXPECT_EQ(bits(flatten(act(*traced, testing::manyObservations(), 50))), bits(actual)) << name;
  }
}

TEST_F(NetworkFromPython, MustBeTracedInEvaluation) {
  for (const char* name : {"dropout_training.pt", "batch_norm_training.pt"}) {
    expectRefusal(folder_ / name, ExitCode::kBadDependency,
                  {"must be in evaluation, but aten::", "does as in training: call .eval() before tracing"});
  }
}

TEST_F(NetworkFromPython, MustLoadAndActInTime) {
  for (const char* name : {"endless_to_load.pt", "endless_to_act.pt"}) {
    try {
      NetworkPolicy::load(folder_ / name, InstructionSet::kBaseline, std::chrono::seconds(1));
      FAIL() << name << " is accepted";
    } catch (const RuntimeFault& error) {
      EXPECT_THAT(error.what(), HasSubstr(std::string(name) + ": must load and act within 1 s, but does not return"));
    }
  }
}

TEST_F(NetworkFromPython, IsRefusedIfItIsAPickle) {
  for (const char* name : {"state_dict.pt", "legacy_state_dict.pt", "pickled_module.pt", "pickle.pt"}) {
    expectRefusal(folder_ / name, ExitCode::kInvalidInput, {name, "must be TorchScript"});
  }
}

TEST(ShippedNetwork, RunsOnTheKernelAsOnLibtorch) {
  const fs::path path = fs::path(PUSHT_POLICIES_DIR) / "bc_policy.ts.pt";
  const auto policy = NetworkPolicy::load(path);
  EXPECT_EQ(policy->info().operations,
            "10, subtract, multiply, divide, subtract, max, min, matrix 512, add, max, matrix 512, add, max, matrix 2, "
            "add, add, divide, multiply, add");
  const std::vector<float> actual = flatten(act(*policy, observations()));
  const std::vector<float> expected = onLibtorch(path);
  testing::expectNear(actual, expected, 1e-5F);
  if (testing::onReferenceBlas()) {
    EXPECT_EQ(bits(actual), bits(expected));
  }
  expectRowsNotToDependOnTheBatch(*policy);
}

TEST(UntrainedNetwork, HasTheWeightsOfPythonsTorch) {
  // Printed by torch 1.13.1 in Python: torch.manual_seed(0), then nn.Sequential(nn.Linear(10, 64), nn.ReLU(),
  // nn.Linear(64, 64), nn.ReLU(), nn.Linear(64, 2)); of each layer weight[0, 0], weight[0, 1], weight[-1, -1],
  // bias[-1].
  const std::vector<std::array<float, 4>> expected = {{-0.0023675405F, 0.169638351F, 0.137053922F, 0.0720238686F},
                                                      {-0.0792438686F, -0.0135167092F, -0.0668498129F, -0.0227290392F},
                                                      {-0.108832985F, -0.0920397341F, -0.0277298987F, -0.00187969208F}};
  const std::vector<Operation> operations = untrainedOperations(0);
  ASSERT_EQ(operations.size(), 9U);
  for (std::size_t layer = 0; layer < expected.size(); ++layer) {
    const Operation& matrix = operations[3 * layer];
    const Operation& bias = operations[3 * layer + 1];
    EXPECT_EQ(matrix.operand[0], expected[layer][0]);
    EXPECT_EQ(matrix.operand[matrix.columns], expected[layer][1]);
    EXPECT_EQ(matrix.operand.back(), expected[layer][2]);
    EXPECT_EQ(bias.operand.back(), expected[layer][3]);
  }
}

TEST(UntrainedNetwork, ActsAsInPython) {
  // tanh of that network at [[0.0, 0.1, ..., 0.9]].
  const auto policy = NetworkPolicy::untrained(0);
  Observation observation{};
  for (std::size_t i = 0; i < observation.size(); ++i) {
    observation[i] = static_cast<float>(i) / 10.0F;
  }
  const Action action = act(*policy, {observation}).front();
  EXPECT_NEAR(action[0], 0.0291392505F, 1e-6F);
  EXPECT_NEAR(action[1], -0.00816848222F, 1e-6F);
  EXPECT_TRUE(policy->info().runsOnKernel());
  EXPECT_EQ(policy->info().sha256, "");
}

TEST(UntrainedNetwork, DependsOnTheSeedAlone) {
  const auto a = act(*NetworkPolicy::untrained(7), observations());
  EXPECT_EQ(a, act(*NetworkPolicy::untrained(7), observations()));
  EXPECT_NE(a, act(*NetworkPolicy::untrained(8), observations()));
}

}  // namespace
}  // namespace pusht
