// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "sim2sim_protocol/protocol.hpp"

namespace sim2sim {

/// Shard of a sweep: all rows over a contiguous share of the episodes.
struct Shard {
  int number = 1;  ///< from 1 to `of`
  int of = 1;      ///< number of shards, at most 1 000 000

  /// Reads "2/5". Throws InvalidInput for another text.
  static Shard from(const std::string& text);
  std::string text() const { return std::to_string(number) + "/" + std::to_string(of); }

  /// Protocol of this shard: its share of the episodes of `protocol`. Shares differ by at most one episode. Throws
  /// InvalidInput if there are fewer episodes than shards.
  Protocol share(const Protocol& protocol) const;
};

}  // namespace sim2sim
