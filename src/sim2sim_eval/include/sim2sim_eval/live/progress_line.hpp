// SPDX-License-Identifier: BSD-3-Clause
/// How far a live run is, in words.
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "sim2sim_protocol/results/summary.hpp"

namespace sim2sim {

/// When to say how far a run is, and how long it still takes if it goes on like this.
class ProgressLine {
 public:
  using Clock = std::chrono::steady_clock;

  explicit ProgressLine(int episodes, Clock::time_point begin = Clock::now())
      : episodes_(episodes), begin_(begin), last_(begin) {}

  /// Whether the last line, or the beginning, was 5 s ago: then there is to be one now. Costs next to nothing.
  bool due(Clock::time_point now = Clock::now());

  /// After so many control steps of the episode under way; `finished` are the episodes before it, none at first.
  std::string text(const std::optional<Summary>& finished, int step, Clock::time_point now = Clock::now()) const;

  /// [s] after so many episodes, one at least.
  double secondsLeft(int finished, Clock::time_point now = Clock::now()) const;

 private:
  int episodes_;
  Clock::time_point begin_;
  Clock::time_point last_;
};

}  // namespace sim2sim
