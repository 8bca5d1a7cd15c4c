// SPDX-License-Identifier: BSD-3-Clause
#include "live/progress_line.hpp"

#include "pusht_task/numbers.hpp"

namespace sim2sim {
namespace {

constexpr std::chrono::seconds kLinePeriod{5};

}  // namespace

bool ProgressLine::due(Clock::time_point now) {
  if (now - last_ < kLinePeriod) {
    return false;
  }
  last_ = now;
  return true;
}

std::string ProgressLine::text(const std::optional<Summary>& finished, int step, Clock::time_point now) const {
  const int count = finished ? finished->episodes : 0;
  std::string line = std::to_string(count) + " of " + std::to_string(episodes_) +
                     " episodes finished, the next one is at control step " + std::to_string(step);
  if (!finished) {
    return line;
  }
  return line + "; success: reference " + std::to_string(finished->reference.successes) + ", engine " +
         std::to_string(finished->engine.successes) + "; about " + pusht::fixedText(secondsLeft(count, now), 0) +
         " s left";
}

double ProgressLine::secondsLeft(int finished, Clock::time_point now) const {
  const std::chrono::duration<double> elapsed = now - begin_;
  return elapsed.count() / finished * (episodes_ - finished);
}

}  // namespace sim2sim
