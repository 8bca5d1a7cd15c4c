// SPDX-License-Identifier: BSD-3-Clause
// Checkpoints that do not do what their descriptions say, or draw random numbers themselves.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <ostream>
#include <string>
#include <vector>

#include "libtorch_testing.hpp"
#include "network_testing.hpp"
#include "pusht_policy/network_policy.hpp"
#include "pusht_task/error.hpp"

namespace pusht {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// A method forward, its description, and parts of the message with which the two are refused.
struct BadCheckpoint {
  const char* name;
  const char* forward;
  const char* description;
  std::vector<std::string> message;
  ExitCode exit_code = ExitCode::kBadDependency;
};

std::ostream& operator<<(std::ostream& stream, const BadCheckpoint& bad) { return stream << bad.name; }

constexpr const char* kPlain = R"({"format": 1, "observations": 1, "actions": 1})";
constexpr const char* kChunk = R"({"format": 1, "observations": 2, "actions": 8})";
constexpr const char* kState = R"({"format": 1, "observations": 1, "actions": 1, "state": {"shape": [3]}})";
constexpr const char* kNoise =
    R"({"format": 1, "observations": 1, "actions": 1, "noise": {"shape": [4], "distribution": "normal"}})";

const std::vector<BadCheckpoint>& badCheckpoints() {
  static const std::vector<BadCheckpoint> cases = {
      {"OtherActions",
       "def forward(self, x):\n  return torch.zeros(1, 4, 2)\n",
       kChunk,
       {"must map float [1, 2, 10] to float [1, 8, 2], as its policy.json says, not to float [1, 4, 2]"}},
      {"OtherObservations",
       "def forward(self, x):\n  return (x - torch.ones(3, 10))[:, :1, :2]\n",
       kChunk,
       {"must map float [1, 2, 10] to float [1, 8, 2], as its policy.json says, but fails: ", "3"}},
      {"NoTime",
       "def forward(self, x):\n  return torch.zeros(1, 2)\n",
       kPlain,
       {"must map float [1, 1, 10] to float [1, 1, 2], as its policy.json says, not to float [1, 2]"}},
      {"DoubleActions", "def forward(self, x):\n  return x[:, :, :2].double()\n", kPlain, {"not to double [1, 1, 2]"}},
      {"TakesNoState",
       "def forward(self, x):\n  return x[:, :, :2]\n",
       kState,
       {"must map float [1, 1, 10], state float [1, 3] to float [1, 1, 2], state float [1, 3]", "but fails: "}},
      {"GivesNoState",
       "def forward(self, x, state):\n  return x[:, :, :2] + state.sum()\n",
       kState,
       {"not to float [1, 1, 2]"}},
      {"GivesAStateThatIsNotDescribed",
       "def forward(self, x):\n  return x[:, :, :2], x\n",
       kPlain,
       {"not to Tuple (float [1, 1, 2], float [1, 1, 10])"}},
      {"OtherState",
       "def forward(self, x, state):\n  return x[:, :, :2], torch.zeros(1, 5)\n",
       kState,
       {"not to Tuple (float [1, 1, 2], float [1, 5])"}},
      {"StateThatGrows",
       "def forward(self, x, state):\n  return x[:, :, :2], torch.cat([state, state], 1)\n",
       kState,
       {"not to Tuple (float [1, 1, 2], float [1, 6])"}},
      {"StateThatIsNotFinite",
       "def forward(self, x, state):\n  return x[:, :, :2], state + float('inf')\n",
       kState,
       {"its state numbers must be finite, but state number 1 of 3 is inf for probe 0"}},
      {"StateThatOverflows",
       "def forward(self, x, state):\n  return x[:, :, :2], state * 1e38 + torch.full([1, 3], 1e30)\n",
       kState,
       {"its state numbers must be finite, but state number 1 of 3 is inf for probe 1"}},
      {"TakesNoNoise",
       "def forward(self, x):\n  return x[:, :, :2]\n",
       kNoise,
       {"must map float [1, 1, 10], noise float [1, 4] to float [1, 1, 2]", "but fails: "}},
      {"OtherNoise",
       "def forward(self, x, noise):\n  return x[:, :, :2] + noise.reshape(1, 1, 2)\n",
       kNoise,
       {"noise float [1, 4]", "but fails: "}},
      {"NanAtTheSeventhAction",
       "def forward(self, x):\n  y = torch.zeros(1, 8, 2)\n  y[:, 6, 1] = float('nan')\n  return y\n",
       kChunk,
       {"its actions must be finite, but action 7 of 8 is nan for probe 0"}},
      {"DrawsItsNoise",
       "def forward(self, x):\n  return torch.randn_like(x)[:, :, :2]\n",
       kPlain,
       {"must not draw random numbers, but has aten::randn_like: it must take noise as an input, and say so"}},
      {"DrawsNoiseInPlace",
       "def forward(self, x):\n  return torch.zeros(1, 1, 2).uniform_(0.0, 1.0)\n",
       kPlain,
       {"must not draw random numbers, but has aten::uniform_"}},
      {"DropsOutAlways",
       "def forward(self, x):\n  return torch.dropout(x, 0.5, True)[:, :, :2]\n",
       kPlain,
       {"must be in evaluation, but aten::dropout does as in training: call .eval() before tracing"}},
      {"ComputesOnAnotherDevice",
       "def forward(self, x):\n  return x[:, :, :2] + torch.zeros([1, 1, 2], device='cuda:0')\n",
       kPlain,
       {"must compute on the CPU, but has a constant on cuda:0: move the module to the CPU before it is traced"}},
      {"DrawsForRareObservations",
       "def forward(self, x):\n  y = x[:, :, :2]\n  if bool(x.max() > 100.0):\n    y = y + torch.rand(1, 1, 2)\n"
       "  return y\n",
       kPlain,
       {"must not draw random numbers, but has aten::rand:"}},
      {"HasAMemoryOfItsOwn",
       "def forward(self, x):\n  self.calls = self.calls + 1.0\n  return x[:, :, :2] + self.calls\n",
       kPlain,
       {"must act the same on the same inputs, but has a memory or is random: it must take its state and its noise as "
        "inputs"}},
      {"NoJson",
       "def forward(self, x):\n  return x[:, :, :2]\n",
       "observations: 1",
       {"policy.json: must be JSON, but is not at byte 1"},
       ExitCode::kInvalidInput},
      {"ExecutesMoreThanItAnswers",
       "def forward(self, x):\n  return x[:, :, :2]\n",
       R"({"format": 1, "observations": 1, "actions": 1, "execute": 2})",
       {"policy.json: execute 2: must be a whole number from 1 to 1, the actions of an answer"},
       ExitCode::kInvalidInput},
  };
  return cases;
}

class DescribedCheckpoint : public ::testing::TestWithParam<BadCheckpoint> {
 protected:
  const testing::TemporaryFolder folder_;
};

TEST_P(DescribedCheckpoint, IsRefusedByShapeAndRule) {
  const BadCheckpoint& bad = GetParam();
  testing::writeNetwork(folder_ / "bad.pt", bad.forward, bad.description);
  try {
    NetworkPolicy::load(folder_ / "bad.pt");
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.exitCode(), bad.exit_code) << error.what();
    EXPECT_THAT(error.what(), Not(HasSubstr("\n")));
    EXPECT_THAT(error.what(), HasSubstr((folder_ / "bad.pt").string()));
    for (const std::string& part : bad.message) {
      EXPECT_THAT(error.what(), HasSubstr(part));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Bad, DescribedCheckpoint, ::testing::ValuesIn(badCheckpoints()),
                         [](const auto& info) { return info.param.name; });

/// Random operations that are never reached are no fault: a network may draw noise where it is given none.
TEST(SoundCheckpoint, MayDrawNoiseThatItIsGivenHere) {
  const testing::TemporaryFolder folder;
  const std::string forward =
      "def forward(self, x, noise: Optional[Tensor] = None):\n"
      "  if noise is None:\n"
      "    noise = torch.randn(1, 4)\n"
      "  return x[:, :, :2] + noise.sum()\n";
  testing::writeNetwork(folder / "policy.pt", forward, kNoise);
  EXPECT_NO_THROW(NetworkPolicy::load(folder / "policy.pt"));
  testing::writeNetwork(folder / "policy.pt", forward, kPlain);
  EXPECT_THROW(NetworkPolicy::load(folder / "policy.pt"), Error) << "without noise it does draw";
}

TEST(SoundCheckpoint, MayHaveRandomLayersThatRest) {
  const testing::TemporaryFolder folder;
  const std::string forward =
      "def forward(self, x):\n  return torch.rrelu(torch.dropout(x, 0.5, False), 0.1, 0.3, False)[:, :, :2]\n";
  testing::writeNetwork(folder / "policy.pt", forward, kPlain);
  EXPECT_NO_THROW(NetworkPolicy::load(folder / "policy.pt"));
}

}  // namespace
}  // namespace pusht
