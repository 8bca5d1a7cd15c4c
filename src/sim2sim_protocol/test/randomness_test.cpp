// SPDX-License-Identifier: BSD-3-Clause
/// Random numbers of policy and loop: repeats of starts, streams, and runs that depend on nothing else.
#include <gmock/gmock.h>

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "pusht_engine/two_mass_engine.hpp"
#include "pusht_engine/two_mass_lanes.hpp"
#include "pusht_policy/scripted_expert.hpp"
#include "pusht_task/loop.hpp"
#include "pusht_task/spawn.hpp"
#include "pusht_testing/refusal.hpp"
#include "pusht_testing/temporary_folder.hpp"
#include "sim2sim_protocol/protocol.hpp"
#include "sim2sim_protocol/reference_cache.hpp"
#include "sim2sim_protocol/results/episodes_csv.hpp"
#include "sim2sim_protocol/runner.hpp"

namespace sim2sim {
namespace {

using pusht::Role;
using pusht::testing::refusalOf;

/// Drives at the tee, unsteadily; what is random is of the rollout's seed alone.
class DicePolicy : public pusht::Policy {
 public:
  std::unique_ptr<Memory> begin(const pusht::Beginning& beginning) const override {
    return std::make_unique<Dice>(beginning.seed);
  }
  void act(pusht::Span<const Query> queries, pusht::Span<pusht::Action> actions) override {
    for (std::size_t row = 0; row < queries.size(); ++row) {
      pusht::NumpyGenerator& numbers = static_cast<Dice*>(queries[row].memory)->numbers;
      for (std::size_t axis = 0; axis < 2; ++axis) {
        const float to_tee = queries[row].observation[2 + axis] - queries[row].observation[axis];
        actions[row][axis] = 5.0F * to_tee + static_cast<float>(numbers.uniform(-0.5, 0.5));
      }
    }
  }

 private:
  struct Dice : Memory {
    explicit Dice(std::uint64_t seed) : numbers(seed, "dice") {}
    pusht::NumpyGenerator numbers;
  };
};

Worlds twoEngines(int lanes) {
  pusht::TwoMassParameters heavy;
  heavy.block_damp = 20.0;
  return {std::make_unique<pusht::TwoMassLanes>(lanes, heavy), std::make_unique<pusht::TwoMassLanes>(lanes),
          std::make_unique<pusht::TwoMassLanes>(lanes)};
}

Worlds enginesWithoutReference(int lanes) {
  Worlds worlds = twoEngines(lanes);
  worlds[kReferenceClosed] = nullptr;
  return worlds;
}

using MakePolicy = std::function<std::unique_ptr<pusht::Policy>()>;

std::unique_ptr<pusht::Policy> dice() { return std::make_unique<DicePolicy>(); }

/// Expert in loops that differ between the roles, with noise of all kinds.
std::unique_ptr<pusht::Policy> noisyExpert() {
  pusht::ParameterSet reference = pusht::plainLoop();
  reference.set("action_noise", "0.2");
  reference.set("observation_delay", "1");
  pusht::ParameterSet engine = pusht::plainLoop();
  engine.set("observation_noise_position", "0.005");
  engine.set("observation_noise_yaw", "0.05");
  engine.set("hold", "2");
  return pusht::looped(std::make_unique<pusht::ScriptedExpert>(), reference, engine);
}

/// episodes.csv of a run.
std::string csvOf(const Protocol& protocol, const MakePolicy& make_policy, int threads = 1,
                  const ReferenceCache* references = nullptr, Worlds (*make_worlds)(int) = twoEngines) {
  std::vector<EpisodeResult> episodes;
  runProtocol(
      protocol, {make_worlds, make_policy}, threads, references,
      [&](const Episode& episode) { episodes.push_back(episode.result()); }, [] { return false; });
  return episodesCsv(protocol, episodes);
}

Protocol withRepeats(int starts, int repeats) {
  Protocol protocol;
  protocol.repeats = repeats;
  protocol.episodes = starts * repeats;
  protocol.horizon = 60;
  return protocol;
}

TEST(Repeats, ShareAStart) {
  const Protocol protocol = withRepeats(2, 3);
  EXPECT_EQ(protocol.starts(), 2);
  EXPECT_EQ(protocol.spawnSeed(2), protocol.spawnSeed(0));
  EXPECT_EQ(*protocol.spawnSeed(3), *protocol.spawnSeed(0) + 1);
  EXPECT_EQ(protocol.repeat(5), 2);
  EXPECT_EQ(protocol.cacheKey(0), Protocol().cacheKey(0)) << "the first is kept as without repeats";
  EXPECT_EQ(protocol.cacheKey(2), protocol.cacheKey(0) + "#2");
}

TEST(Repeats, DivideTheEpisodes) {
  Protocol protocol;
  protocol.repeats = 3;
  EXPECT_EQ(refusalOf([&] { protocol.validate(); }),
            "repeats 3: must divide episodes 50 and first_episode 0, because a start has that many episodes, one after "
            "the other");
  protocol.episodes = 51;
  protocol.validate();
  protocol.first_episode = 1;
  EXPECT_EQ(refusalOf([&] { protocol.validate(); }),
            "repeats 3: must divide episodes 51 and first_episode 1, because a start has that many episodes, one after "
            "the other");
  protocol.first_episode = 3;
  protocol.validate();
  protocol.repeats = 0;
  EXPECT_EQ(refusalOf([&] { protocol.validate(); }), "repeats 0: must be from 1 to 1000");
}

TEST(Randomness, IsTheSameInBothRolesUnlessAskedOtherwise) {
  Protocol protocol = withRepeats(2, 3);
  const std::uint64_t seed = protocol.beginning(1, Role::kReference).seed;
  EXPECT_EQ(protocol.beginning(1, Role::kEngine).seed, seed);
  EXPECT_NE(protocol.beginning(0, Role::kReference).seed, seed);
  EXPECT_NE(protocol.beginning(4, Role::kReference).seed, seed);
  protocol.independent_noise = true;
  EXPECT_EQ(protocol.beginning(1, Role::kReference).seed, seed);
  EXPECT_NE(protocol.beginning(1, Role::kEngine).seed, seed);
  protocol.noise_seed = 1;
  EXPECT_NE(protocol.beginning(1, Role::kReference).seed, seed);
}

TEST(Randomness, OfAnEpisodeDoesNotDependOnTheOthers) {
  for (const MakePolicy& policy : {MakePolicy(dice), MakePolicy(noisyExpert)}) {
    const Protocol whole = withRepeats(6, 2);
    const std::string alone = csvOf(whole, policy);
    for (const int threads : {2, 3}) {
      EXPECT_EQ(csvOf(whole, policy, threads), alone) << threads << " threads";
    }
    Protocol part = whole;
    part.first_episode = 8;
    part.episodes = 4;
    const std::string rows = csvOf(part, policy);
    const std::size_t begin = rows.find('\n') + 1;
    EXPECT_NE(alone.find(rows.substr(begin)), std::string::npos) << "a part of a run has the rows of the whole";
  }
}

TEST(Randomness, OfTheReferenceIsKeptByRepeat) {
  const pusht::testing::TemporaryFolder folder;
  const ReferenceCache references(folder.path(), {{"reference", "heavy"}});
  const Protocol protocol = withRepeats(4, 3);
  const std::string without = csvOf(protocol, dice);
  EXPECT_EQ(csvOf(protocol, dice, 1, &references), without);
  EXPECT_EQ(csvOf(protocol, dice, 2, &references, enginesWithoutReference), without);
}

TEST(Randomness, ChangesFromRepeatToRepeatAndWithItsSeed) {
  Protocol protocol = withRepeats(1, 2);
  std::vector<EpisodeResult> episodes;
  const auto results = [&] {
    episodes.clear();
    runProtocol(
        protocol, {twoEngines, dice}, 1, nullptr, [&](const Episode& episode) { episodes.push_back(episode.result()); },
        [] { return false; });
    return std::pair(episodes[0].rollouts[kEngineClosed].at("final_position_error"),
                     episodes[1].rollouts[kEngineClosed].at("final_position_error"));
  };
  const auto [first, second] = results();
  EXPECT_NE(first, second);
  protocol.noise_seed = 5;
  EXPECT_NE(results().first, first);
}

TEST(Randomness, ALoopOfDelayIsAPolicyThatIsLate) {
  class Late : public pusht::Policy {
   public:
    std::unique_ptr<Memory> begin(const pusht::Beginning& beginning) const override {
      auto memory = std::make_unique<Waiting>();
      memory->expert = expert_.begin(beginning);
      return memory;
    }
    void act(pusht::Span<const Query> queries, pusht::Span<pusht::Action> actions) override {
      for (std::size_t row = 0; row < queries.size(); ++row) {
        auto& memory = static_cast<Waiting&>(*queries[row].memory);
        const Query query{queries[row].observation, memory.expert.get()};
        actions[row] = memory.first;
        memory.first = memory.second;
        expert_.act({&query, 1}, {&memory.second, 1});
      }
    }

   private:
    struct Waiting : Memory {
      std::unique_ptr<Memory> expert;
      pusht::Action first{};
      pusht::Action second{};
    };
    pusht::ScriptedExpert expert_;
  };
  Protocol protocol = withRepeats(8, 1);
  protocol.horizon = 150;
  const auto by_loop = [] {
    pusht::ParameterSet loop = pusht::plainLoop();
    loop.set("action_delay", "2");
    return pusht::looped(std::make_unique<pusht::ScriptedExpert>(), loop, loop);
  };
  const std::string late = csvOf(protocol, [] { return std::make_unique<Late>(); });
  EXPECT_EQ(csvOf(protocol, by_loop), late);
  EXPECT_NE(csvOf(protocol, [] { return std::make_unique<pusht::ScriptedExpert>(); }), late);
}

TEST(Execute, BeyondTheAnswerOfAPolicyIsRefused) {
  Protocol protocol = withRepeats(2, 1);
  protocol.execute = 2;
  EXPECT_EQ(refusalOf([&] { csvOf(protocol, [] { return std::make_unique<pusht::ScriptedExpert>(); }); }),
            "execute 2: must be from 1 to 1, the actions of an answer of the policy; 0: as many as it says");
}

}  // namespace
}  // namespace sim2sim
