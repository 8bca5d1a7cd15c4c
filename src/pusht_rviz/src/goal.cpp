// SPDX-License-Identifier: BSD-3-Clause
#include "goal.hpp"

#include <cstddef>
#include <limits>

#include "pusht_task/constants.hpp"
#include "pusht_task/numbers.hpp"

namespace pusht_rviz {
namespace {

using pusht::decimal;
using pusht::kFirstSpawnSeed;

/// Adds what the parameters break, each under `prefix` and its name.
void refuse(const std::string& prefix, const ParameterDraft& parameters, std::vector<Refusal>& refusals) {
  for (const DraftedParameter& drafted : parameters) {
    const std::string rule = drafted.differs() ? refusalOf(drafted.descriptor, drafted.text) : "";
    if (!rule.empty()) {
      refusals.push_back({prefix + drafted.descriptor.name, rule});
    }
  }
}

}  // namespace

std::optional<std::uint64_t> spawnSeedOf(const std::string& seed, const std::string& first_episode) {
  const std::optional<std::uint64_t> run = decimal<std::uint64_t>(seed);
  const std::optional<std::uint64_t> episode = decimal<std::uint64_t>(first_episode);
  constexpr std::uint64_t kGreatest = std::numeric_limits<std::uint64_t>::max() - kFirstSpawnSeed;
  if (!run || !episode || *episode > kGreatest || *run > kGreatest - *episode) {
    return std::nullopt;
  }
  return kFirstSpawnSeed + *run + *episode;
}

Reading firstEpisodeOf(const std::string& spawn_seed, const std::string& seed) {
  const std::optional<std::uint64_t> least = spawnSeedOf(seed, "0");
  if (!least) {
    return {0, "seed '" + seed + "': 10000 + seed must be below 2^64"};
  }
  const std::optional<std::uint64_t> given = decimal<std::uint64_t>(spawn_seed);
  if (!given || *given < *least) {
    return {0,
            "spawn seed '" + spawn_seed + "': must be a whole number from 10000 + seed on, " + std::to_string(*least)};
  }
  return {*given - *least};
}

std::string nextFolder(const std::string& folder) {
  const std::size_t end = folder.find_last_not_of('/');
  if (end == std::string::npos) {
    return folder;
  }
  const std::string name = folder.substr(0, end + 1);
  const std::size_t dash = name.find_last_not_of("0123456789");
  const std::optional<std::uint32_t> number =
      dash == std::string::npos || name[dash] != '-' ? std::nullopt : decimal<std::uint32_t>(name.substr(dash + 1));
  return number ? name.substr(0, dash + 1) + std::to_string(std::uint64_t{*number} + 1) : name + "-2";
}

Draft goalFrom(const RunDraft& run) {
  Draft draft;
  refuse("", run.options, draft.refusals);
  draft.goal.options = run.options.named();
  if (const std::optional<std::size_t> seed = run.options.find(kSeedOption); seed && run.spawned) {
    const Reading episode = firstEpisodeOf(run.spawn_seed, run.options[*seed].text);
    if (!episode.refusal.empty()) {
      draft.refusals.push_back({"spawn_seed", episode.refusal});
    }
  }
  draft.goal.out = {run.out};
  if (!run.policy.empty()) {
    draft.goal.policy_namespace = {run.policy};
  }
  if (run.rate) {
    draft.goal.rate = {*run.rate};
  }
  const auto take = [&](const std::string& node, const SimulatorDraft& simulator, auto& kind, auto& parameters) {
    refuse(node + ".", simulator.parameters, draft.refusals);
    if (!simulator.kind.empty()) {
      kind = {simulator.kind};
    }
    parameters = simulator.parameters.named();
  };
  take("reference", run.reference, draft.goal.reference, draft.goal.reference_parameters);
  take("engine", run.engine, draft.goal.engine, draft.goal.engine_parameters);
  return draft;
}

}  // namespace pusht_rviz
