// SPDX-License-Identifier: BSD-3-Clause
/// Hypotheses on the policies of a matrix, fixed before the sweep was run, and what the sweep says of them.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "sim2sim_protocol/results/matrix.hpp"
#include "sim2sim_statistics/intervals.hpp"

namespace sim2sim {

inline constexpr const char* kSuccessFigure = "success";  ///< success rate in closed loop

/// Difference of the means of two groups of policies in one simulator, more - less.
struct GroupDifference {
  std::string more;                     ///< group
  std::string less;                     ///< group
  std::string simulator;                ///< MatrixSimulator::name
  std::string figure = kSuccessFigure;  ///< or one of kMatrixDivergences
  bool paired = false;  ///< policy i of one group belongs to policy i of the other, as two epochs of one training
};

/// Kendall's tau of the success of policies in two simulators.
struct GroupRanking {
  std::vector<std::string> groups;  ///< whose policies are ranked
  std::string here;                 ///< MatrixSimulator::name
  std::string there;                ///< likewise
};

/// Hypothesis: a figure has a sign, or is small.
struct Hypothesis {
  std::string name;
  std::variant<GroupDifference, GroupRanking> figure;
  /// Side on which the whole interval must be: above 0, below 0, or within `margin` of 0.
  enum class Side { kAbove, kBelow, kWithin } side = Side::kAbove;
  double margin = 0.0;  ///< in the figure's unit; of Side::kWithin
};

/// What the sweep says of a hypothesis.
struct HypothesisResult {
  Hypothesis hypothesis;
  /// Value of the figure; its interval is over further trainings and starts (sim2sim_statistics/crossed.hpp), that of a
  /// ranking over further policies and starts (sim2sim_statistics/ranking.hpp). A ranking has no p-value; a difference
  /// of divergences that few starts carry (isCarriedByFew()) has neither interval nor p-value.
  Difference found;
  std::optional<double> adjusted_p{};  ///< after Holm, over all differences of which a sign is expected
  enum class Verdict {
    kHolds,         ///< the whole interval is on its side; the sign of a difference is significant after Holm, too
    kContradicted,  ///< likewise on the other side, or outside the margin
    kNotShown,
  } verdict = Verdict::kNotShown;
};

/// Tests the hypotheses. Throws InvalidInput, naming hypothesis, value and rule, for a group, simulator or figure that
/// the matrix does not have, a group without a cell there, a divergence that no episode has for all policies, pairs of
/// groups that differ in size, or a ranking of one simulator with itself, of a group that is named twice, or of fewer
/// than two policies or episodes.
std::vector<HypothesisResult> test(const Matrix& matrix, const std::vector<Hypothesis>& hypotheses);

}  // namespace sim2sim
