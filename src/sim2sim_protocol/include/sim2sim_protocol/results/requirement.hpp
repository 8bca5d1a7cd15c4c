// SPDX-License-Identifier: BSD-3-Clause
/// Requirements of success, as a build server asks for: "transfer > 0.8" of a run, "B > A - 0.05" of two policies.
///
/// A requirement is FIGURE > NUMBER, or FIGURE > FIGURE + NUMBER; with < in place of >, - in place of +, and without
/// the second number. A number may be in percent: 80%. FIGURE is `reference` or `engine`, a success rate, or
/// `transfer`. Where runs are held against each other it is RUN.FIGURE, and RUN alone is its engine; the runs are A,
/// the baseline, B, C, ...
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim2sim_protocol/protocol.hpp"
#include "sim2sim_protocol/results/contrast.hpp"
#include "sim2sim_protocol/results/run_results.hpp"
#include "sim2sim_protocol/results/summary.hpp"
#include "sim2sim_statistics/intervals.hpp"

namespace sim2sim {

/// What is required.
struct Requirement {
  /// Figure of a run.
  struct Figure {
    std::string name;          ///< "reference", "engine" or "transfer"
    std::optional<int> run{};  ///< 0: A; none: the only run
  };

  std::string text;  ///< as it was given
  Figure figure;     ///< less `subtracted` must be beyond `bound`
  std::optional<Figure> subtracted{};
  bool is_more = true;  ///< above the bound; else below
  double bound = 0.0;

  /// Reads a requirement. Throws InvalidInput with the rule that it breaks.
  explicit Requirement(std::string given);

  /// Throws InvalidInput unless it is one of a single run, and the run will have its interval: one that ends when a
  /// share is decided has that of the transfer alone, and answers for that share.
  void requireOneRun(const std::optional<double>& until_decided) const;

  /// Throws InvalidInput unless it is one of the reference's success, all that a run without an engine has.
  void requireReferenceAlone() const;

  /// Throws InvalidInput unless it is one of `runs` runs, and compares none but with the first.
  void requireRuns(int runs) const;
};

/// Letter of a run: A for 0. Past Z it is "?", which no requirement can name.
std::string letterOf(int run);

/// Answer to a requirement.
struct RequirementResult {
  enum class Verdict { kMet, kNotMet, kCannotSay };

  std::string requirement;
  Verdict verdict;
  Estimate found;                      ///< of the figure, or of the difference of two
  std::optional<int> starts_needed{};  ///< that would decide in 80 % of runs, if `found` is the truth; none: too many
  bool may_go_on = false;              ///< a run that ends when it is decided, and was not

  /// "transfer > 0.8: cannot say, 0.970 [0.771, 1.230]; 343 starts would decide"
  std::string sentence() const;
};

/// Answer of a run. Of a requirement with `is_more` it is met if the interval is above the bound, and not met if none
/// of it is.
RequirementResult judge(const Requirement& requirement, const Protocol& protocol, const Summary& summary);

/// Answer of runs that were contrasted. `contrasts` are those of `others` against `baseline`.
RequirementResult judge(const Requirement& requirement, const RunResults& baseline,
                        const std::vector<RunResults>& others, const std::vector<Contrast>& contrasts);

}  // namespace sim2sim
