// SPDX-License-Identifier: BSD-3-Clause
// Networks with a history, chunks of actions, a state and noise.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/random/normal_distribution.hpp>
#include <filesystem>
#include <future>
#include <string>
#include <vector>

#include "libtorch_testing.hpp"
#include "network_testing.hpp"
#include "pusht_policy/network_policy.hpp"
#include "pusht_task/error.hpp"

namespace pusht {
namespace {

namespace fs = std::filesystem;
using testing::bits;
using testing::drive;
using testing::flatten;
using ::testing::HasSubstr;
using testing::observations;

class RememberingNetwork : public ::testing::Test {
 protected:
  /// Policy of a network with this method forward, and this description beside its format.
  std::unique_ptr<NetworkPolicy> policy(const std::string& forward, const std::string& description) const {
    testing::writeNetwork(folder_ / "policy.pt", forward, R"({"format": 1, )" + description + "}");
    return NetworkPolicy::load(folder_ / "policy.pt");
  }

  /// Policy whose actions say which call of the network they are from, and which one of its answer they are.
  std::unique_ptr<NetworkPolicy> counting() const {
    return policy(
        "def forward(self, x, state):\n"
        "  state = state + 1.0\n"
        "  return torch.stack([state.expand(1, 4), torch.arange(4.0).unsqueeze(0)], 2), state\n",
        R"("observations": 1, "actions": 4, "execute": 3, "state": {"shape": [1]})");
  }

  /// Policy that answers with its noise, so many actions at a time.
  std::unique_ptr<NetworkPolicy> echo(const std::string& distribution, int actions) const {
    const std::string count = std::to_string(actions);
    return policy("def forward(self, x, noise):\n  return noise\n",
                  R"("observations": 1, "actions": )" + count + R"(, "noise": {"shape": [)" + count +
                      R"(, 2], "distribution": ")" + distribution + "\"}");
  }

  const testing::TemporaryFolder folder_;
};

TEST_F(RememberingNetwork, SeesEveryControlStepAndTheFirstOneAsItsPast) {
  // Its two actions are the oldest and the latest of three observations; both are executed.
  const auto policy = this->policy("def forward(self, x):\n  return torch.stack([x[:, 0, :2], x[:, 2, :2]], 1)\n",
                                   R"("observations": 3, "actions": 2)");
  const std::vector<Action> actions = drive(*policy, {{}}, 8, 1).front();
  const auto seen = [](int step) { return Action{observations()[step][0], observations()[step][1]}; };
  EXPECT_EQ(actions, (std::vector<Action>{seen(0), seen(0), seen(0), seen(2), seen(2), seen(4), seen(4), seen(6)}));
}

TEST_F(RememberingNetwork, IsAskedWhenTheActionsToBeExecutedHaveRunOut) {
  const auto policy = counting();
  for (int execute = 0; execute <= 4; ++execute) {
    const int executed = execute == 0 ? 3 : execute;
    const std::vector<Action> actions = drive(*policy, {{0, execute}}, 13, 1).front();
    for (int step = 0; step < 13; ++step) {
      const int calls = step / executed + 1;
      const Action expected = {static_cast<float>(calls), static_cast<float>(step % executed)};
      EXPECT_EQ(actions[step], expected) << "execute " << execute << ", step " << step;
    }
  }
}

TEST_F(RememberingNetwork, CannotExecuteMoreThanItAnswers) {
  const auto policy = counting();
  for (const int execute : {5, -1}) {
    try {
      policy->begin({0, execute});
      FAIL() << execute << " is accepted";
    } catch (const InvalidInput& error) {
      EXPECT_THAT(error.what(), HasSubstr("execute " + std::to_string(execute) + ": must be from 1 to 4"));
    }
  }
}

TEST_F(RememberingNetwork, ServesRolloutsThatAreAtOtherStages) {
  const auto policy = counting();
  const auto together = drive(*policy, {{0, 1}, {0, 2}, {0, 3}, {0, 4}}, 12, 4);
  for (int execute = 1; execute <= 4; ++execute) {
    EXPECT_EQ(together[execute - 1], drive(*policy, {{0, execute}}, 12, 1).front());
  }
}

TEST_F(RememberingNetwork, GetsTheNoiseOfItsSeed) {
  const auto policy = echo("normal", 1);
  NumpyGenerator generator(77, "policy noise");
  boost::random::normal_distribution<double> normal;
  const std::vector<Action> actions = drive(*policy, {{77}}, 20, 1).front();
  for (const Action& action : actions) {
    for (const float number : action) {
      EXPECT_EQ(number, static_cast<float>(normal(generator.bits())));
    }
  }
  EXPECT_TRUE(policy->info().description.isStochastic());
}

TEST_F(RememberingNetwork, GetsNewNoiseForEachCallAlone) {
  const auto chunks = drive(*echo("normal", 3), {{5, 3}, {5, 1}}, 9, 2);
  EXPECT_EQ(chunks[0], drive(*echo("normal", 1), {{5}}, 9, 1).front()) << "three times three, or nine times one";
  EXPECT_EQ(chunks[1][1], chunks[0][3]) << "what is not executed is used up";
  EXPECT_EQ(chunks[1][2], chunks[0][6]);
}

TEST_F(RememberingNetwork, GetsUniformNoiseBelowOne) {
  const auto policy = echo("uniform", 1000);
  double sum = 0.0;
  const std::vector<Action> actions = drive(*policy, {{3}}, 20'000, 1).front();
  for (const Action& action : actions) {
    for (const float number : action) {
      ASSERT_TRUE(number >= 0.0F && number < 1.0F) << number;
      sum += number;
    }
  }
  EXPECT_NEAR(sum / 40'000.0, 0.5, 5.0 / std::sqrt(12.0 * 40'000.0)) << "five standard errors";
}

/// The shipped kinds of networks: a chunk on the kernel, a recurrent one, one with noise.
TEST_F(RememberingNetwork, ActsTheSameWhateverTheBatchAndTheThread) {
  const std::vector<Beginning> beginnings = {{1, 0}, {2, 1}, {3, 0}, {1, 0}, {5, 1}, {6, 0}, {7, 1}};
  for (const char* name : {"chunks.pt", "gru.pt", "denoising.pt"}) {
    const auto policy = NetworkPolicy::load(testing::checkpointsFromPython() / name);
    const auto alone = drive(*policy, beginnings, 20, 1);
    for (const std::size_t batch : {2, 3, 7}) {
      EXPECT_EQ(drive(*policy, beginnings, 20, batch), alone) << name << " in batches of " << batch;
    }
    const auto other = policy->clone();
    std::promise<void> go;
    const std::shared_future<void> started = go.get_future().share();
    const auto run = [&, started](NetworkPolicy& copy) {
      started.wait();
      return drive(copy, beginnings, 20, 7);
    };
    auto first = std::async(std::launch::async, [&] { return run(*policy); });
    auto second = std::async(std::launch::async, [&] { return run(*other); });
    go.set_value();
    EXPECT_EQ(first.get(), alone) << name << " in a thread";
    EXPECT_EQ(second.get(), alone) << name << " in another thread";
  }
}

TEST_F(RememberingNetwork, ActsByTheSeedAlone) {
  const auto policy = NetworkPolicy::load(testing::checkpointsFromPython() / "denoising.pt");
  const auto of = [&](std::uint64_t seed) { return drive(*policy, {{seed}}, 12, 1).front(); };
  EXPECT_EQ(of(1), of(1));
  EXPECT_NE(of(1), of(2));
  const auto again = NetworkPolicy::load(testing::checkpointsFromPython() / "denoising.pt");
  EXPECT_EQ(drive(*again, {{1}}, 12, 1).front(), of(1));
  const Beginning engine = {1, 0, Role::kEngine};
  EXPECT_EQ(drive(*policy, {engine}, 12, 1).front(), of(1)) << "common random numbers";
}

TEST_F(RememberingNetwork, OfOneObservationAndOneActionIsThePlainPolicy) {
  const fs::path wrapped = testing::checkpointsFromPython() / "wrapped.pt";
  const fs::path course = testing::checkpointsFromPython() / "course_scripted.pt";
  const auto policy = NetworkPolicy::load(wrapped);
  const auto plain = NetworkPolicy::load(course);
  EXPECT_EQ(policy->begin({}), nullptr) << "nothing to remember";
  EXPECT_EQ(policy->info().operations, plain->info().operations);
  EXPECT_EQ(bits(flatten(testing::act(*policy, observations(), 7))),
            bits(flatten(testing::act(*plain, observations()))));
  const auto policy_on_libtorch = NetworkPolicy::loadOnLibtorch(wrapped);
  const auto plain_on_libtorch = NetworkPolicy::loadOnLibtorch(course);
  EXPECT_EQ(bits(flatten(testing::act(*policy_on_libtorch, observations()))),
            bits(flatten(testing::act(*plain_on_libtorch, observations()))));
}

TEST_F(RememberingNetwork, WithoutRecurrentWeightsIsItsFeedForwardTwin) {
  const auto recurrent = NetworkPolicy::load(testing::checkpointsFromPython() / "gru_still.pt");
  const auto twin = NetworkPolicy::load(testing::checkpointsFromPython() / "gru_twin.pt");
  EXPECT_TRUE(twin->info().runsOnKernel() && recurrent->info().runsOnKernel());
  EXPECT_EQ(bits(flatten(drive(*recurrent, {{}}, 50, 1).front())), bits(flatten(testing::act(*twin, observations()))));
  const auto remembering = NetworkPolicy::load(testing::checkpointsFromPython() / "gru.pt");
  const std::vector<Observation> still(3, observations().front());
  const auto memory = remembering->begin({});
  std::vector<Action> actions(still.size());
  for (std::size_t i = 0; i < still.size(); ++i) {
    const Policy::Query query = {still[i], memory.get()};
    remembering->act({&query, 1}, {&actions[i], 1});
  }
  EXPECT_NE(actions[0], actions[1]) << "with recurrent weights the past counts";
}

TEST_F(RememberingNetwork, RunsOnTheKernelWithItsStateAndItsNoise) {
  for (const char* name :
       {"gru.pt", "denoising.pt", "gru_cell_scripted.pt", "gru_cell_traced.pt", "lstm_cell_scripted.pt",
        "lstm_cell_traced.pt", "lstm_layers_scripted.pt", "lstm_layers_traced.pt"}) {
    const fs::path path = testing::checkpointsFromPython() / name;
    const auto policy = NetworkPolicy::load(path);
    ASSERT_EQ(policy->info().why_not_on_kernel, "") << name;
    const std::vector<Beginning> beginnings = {{1}, {2}, {3}, {4}};
    testing::expectNear(flatten(drive(*policy, beginnings, 50, 4).back()),
                        flatten(drive(*NetworkPolicy::loadOnLibtorch(path), beginnings, 50, 1).back()), 1e-5F);
    const auto baseline = NetworkPolicy::load(path, InstructionSet::kBaseline);
    EXPECT_EQ(drive(*baseline, beginnings, 20, 3), drive(*policy, beginnings, 20, 4)) << name;
  }
}

TEST_F(RememberingNetwork, RunsOnTheKernelIfItIsAStraightLine) {
  const fs::path scripted = testing::checkpointsFromPython() / "chunks.pt";
  const auto policy = NetworkPolicy::load(scripted);
  EXPECT_EQ(policy->info().why_not_on_kernel, "");
  EXPECT_EQ(policy->info().operations, "20, multiply, subtract, matrix 48, add, max, matrix 16, add, multiply");
  const auto on_kernel = flatten(drive(*policy, {{}}, 50, 1).front());
  const auto on_libtorch = flatten(drive(*NetworkPolicy::loadOnLibtorch(scripted), {{}}, 50, 1).front());
  testing::expectNear(on_kernel, on_libtorch, 1e-5F);
  if (testing::onReferenceBlas()) {
    EXPECT_EQ(bits(on_kernel), bits(on_libtorch));
  }
  const auto traced = NetworkPolicy::load(testing::checkpointsFromPython() / "chunks_traced.pt");
  EXPECT_EQ(traced->info().operations, policy->info().operations);
  EXPECT_EQ(traced->info().description.execute, 8);
  EXPECT_EQ(bits(flatten(drive(*traced, {{0, 4}}, 50, 1).front())), bits(on_kernel));
}

TEST_F(RememberingNetwork, MayFailAtTheSeventhActionOfAnAnswer) {
  const auto policy = this->policy(
      "def forward(self, x):\n"
      "  bad = (x[:, :, :1] > 50.0) & (torch.arange(8).reshape(1, 8, 1) == 6)\n"
      "  return torch.zeros(1, 8, 2).masked_fill(bad, float('nan'))\n",
      R"("observations": 1, "actions": 8)");
  Observation observation{};
  observation[0] = 51.0F;  // of no episode, so no probe sees it
  const auto memory = policy->begin({});
  for (int step = 0; step < 8; ++step) {
    Action action{};
    const Policy::Query query = {observation, memory.get()};
    policy->act({&query, 1}, {&action, 1});
    EXPECT_EQ(isFinite(action), step != 6) << "step " << step;
  }
}

}  // namespace
}  // namespace pusht
