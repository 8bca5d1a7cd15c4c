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

}  // namespace pusht_rviz
