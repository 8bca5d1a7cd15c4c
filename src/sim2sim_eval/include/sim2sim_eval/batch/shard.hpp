// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "sim2sim_protocol/protocol.hpp"

namespace sim2sim {

/// A part of a sweep: all rows over a share of the episodes.
struct Shard {
  int number = 1;  ///< from 1 to `of`
  int of = 1;

  /// Throws InvalidInput unless `text` is like "2/5".
  static Shard from(const std::string& text);
  std::string text() const { return std::to_string(number) + "/" + std::to_string(of); }

  /// The episodes of a shard follow those of the one before. Throws InvalidInput if there are fewer episodes than
  /// shards.
  Protocol share(const Protocol& protocol) const;
};

}  // namespace sim2sim
