// SPDX-License-Identifier: BSD-3-Clause
#include "batch/shard.hpp"

#include <charconv>
#include <cstdint>
#include <system_error>

#include "pusht_task/error.hpp"

namespace sim2sim {
namespace {

constexpr int kMostShards = 1'000'000;

}  // namespace

Shard Shard::from(const std::string& text) {
  Shard shard;
  const char* const end = text.data() + text.size();
  const auto number = std::from_chars(text.data(), end, shard.number);
  const bool slash = number.ec == std::errc() && number.ptr != end && *number.ptr == '/';
  const auto of = slash ? std::from_chars(number.ptr + 1, end, shard.of) : number;
  if (!slash || of.ec != std::errc() || of.ptr != end || shard.number < 1 || shard.number > shard.of ||
      shard.of > kMostShards) {
    throw pusht::InvalidInput("shard '" + text + "': must be I/N with I from 1 to N, e.g. 2/5");
  }
  return shard;
}

Protocol Shard::share(const Protocol& protocol) const {
  if (of > protocol.starts()) {
    throw pusht::InvalidInput(
        "shard " + text() + ": there must be at least as many episodes as shards, but there are " +
        std::to_string(protocol.starts()) + (protocol.repeats == 1 ? "" : ", those of a start counted once"));
  }
  const auto before = [&](int shards) {  // all repeats of a start are in one shard
    return protocol.repeats * static_cast<int>(static_cast<std::int64_t>(protocol.starts()) * shards / of);
  };
  Protocol share = protocol;
  share.first_episode = protocol.first_episode + before(number - 1);
  share.episodes = before(number) - before(number - 1);
  return share;
}

}  // namespace sim2sim
