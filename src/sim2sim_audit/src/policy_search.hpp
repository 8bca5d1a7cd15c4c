// SPDX-License-Identifier: BSD-3-Clause
/// Search for the faults of a policy's interface that explain its error.
#pragma once

#include <cstddef>
#include <list>
#include <vector>

#include "policy_interview.hpp"

namespace sim2sim {

/// Corrections that were tried, and the mean error under them [m/s].
struct Trial {
  Corrections corrections{};
  double error = 0.0;
};

/// Result of a search: what is worth being measured on other episodes.
struct Finalists {
  std::vector<Trial> singles{};  ///< the best first
  std::vector<Trial> pairs{};
  std::size_t tried = 0;
  std::list<Correction> refined{};  ///< corrections that the search made itself
};

/// Looks at each correction, and at pairs of two groups, in rounds: all on a few steps, the best ones on all of
/// `sample`; the best one is refined. A pair of a question's and an answer's correction costs nothing, as the policy is
/// asked once for each question. Pairs of two questions' are tried where there may be a fault (beside the best ones) or
/// a single one does not explain it (the common ones), by the error of the `constant` action.
Finalists searchFaults(PolicyInterview& policy, const std::vector<Correction>& questions,
                       const std::vector<Correction>& answers, const Sample& sample, double constant);

}  // namespace sim2sim
