// SPDX-License-Identifier: BSD-3-Clause
/// Progress of a live run in words, for the terminal.
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "sim2sim_protocol/results/summary.hpp"

namespace sim2sim {

/// Progress line: the times at which to print one, its text, and an estimate of the time that is left.
class ProgressLine {
 public:
  using Clock = std::chrono::steady_clock;

  explicit ProgressLine(int episodes, Clock::time_point begin = Clock::now())
      : episodes_(episodes), begin_(begin), last_(begin) {}

  /// True once every 5 s, counted from the beginning: a line is to be printed now. Cheap enough for each control step.
  bool due(Clock::time_point now = Clock::now());

  /// Text of a line. `finished` summarizes the finished episodes, none before the first; `step` is the control step of
  /// the episode under way.
  std::string text(const std::optional<Summary>& finished, int step, Clock::time_point now = Clock::now()) const;

  /// Estimate of the time to the end of the run [s], after `finished` >= 1 episodes, by the mean time of an episode.
  double secondsLeft(int finished, Clock::time_point now = Clock::now()) const;

 private:
  int episodes_;
  Clock::time_point begin_;
  Clock::time_point last_;
};

}  // namespace sim2sim
