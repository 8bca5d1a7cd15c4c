// SPDX-License-Identifier: BSD-3-Clause
/// Answers in sentences about several runs over the same episodes.
#pragma once

#include <string>
#include <vector>

#include "sim2sim_protocol/results/contrast.hpp"

namespace sim2sim {

/// Names that distinguish runs of one policy: title, changed parameters, and parameters in which runs of one kind
/// differ, such as "two-mass engine, block_damp 6.0".
std::vector<std::string> titlesOf(const std::vector<RunResults>& runs);

/// List of all runs, the baseline first.
std::vector<RunResults> allOf(const RunResults& baseline, const std::vector<RunResults>& others);

/// A question about runs, and its answer.
struct Answer {
  std::string question;
  std::string answer;

  std::string text() const { return question + " " + answer; }
};

/// Question and answer about all runs together. `contrasts` are those of `others` against `baseline`; a change counts
/// if it stays a finding after Holm over all of their figures.
Answer answerOf(const RunResults& baseline, const std::vector<RunResults>& others,
                const std::vector<Contrast>& contrasts);

/// Sentence about one run against the baseline: "Against block_damp 6, with block_damp 20 success is not shown to
/// change (...); the position divergence falls by 0.0069 m [0.0024, 0.0114]; ..."
std::string sentenceOf(const RunResults& baseline, const RunResults& other, const Contrast& contrast);

/// Names that distinguish policies: the ends of their paths, with digests of files that have one name.
std::vector<std::string> policyTitles(const std::vector<RunResults>& runs);

/// answerOf() and sentenceOf() of contrasts of policies.
Answer policyAnswer(const RunResults& baseline, const std::vector<RunResults>& others,
                    const std::vector<Contrast>& contrasts);
std::string policySentence(const RunResults& baseline, const RunResults& other, const Contrast& contrast);

}  // namespace sim2sim
