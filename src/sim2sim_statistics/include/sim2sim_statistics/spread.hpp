// SPDX-License-Identifier: BSD-3-Clause
/// What makes the cells of a table differ: groups of policies, simulators, single policies, or the starts that were
/// drawn.
///
/// Every policy plays the same starts in every simulator; a cell is the mean of a policy in a simulator over the
/// starts. Model: cell(p, t) = mean + group(g) + simulator(t) + group x simulator(g, t) + policy(p) + policy x
/// simulator(p, t) + noise of the starts, where p is of group g. Policies are a sample of their group, such as
/// trainings with several seeds. Groups and simulators are fixed, those of the table: over them effects add up to 0,
/// and the variance of an effect is the mean of its squares. So the parts add up to the variance of a cell that is
/// taken at random, each group alike.
///
/// The parts are estimated by the analysis of variance of unweighted group means. Noise needs no model: the sum of
/// squares that it adds to each source is measured from the deviations of single starts, which keeps what cells share
/// because they have the same starts.
/// Source: S. R. Searle, G. Casella and C. E. McCulloch, "Variance Components" (1992), chapters 4 and 5.
///
/// Functions throw std::domain_error, with value and rule, for input out of range.
#pragma once

#include <cstddef>
#include <vector>

#include "sim2sim_statistics/crossed.hpp"

namespace sim2sim {

/// Variances of the sources, in the square of the cells' unit. One whose estimate is negative is 0.
struct Spread {
  double group;             ///< between groups, over all simulators
  double simulator;         ///< between simulators, over all groups
  double group_simulator;   ///< what a group has in one simulator beyond both
  double policy;            ///< between policies of a group, over all simulators
  double policy_simulator;  ///< what a policy has in one simulator beyond its group there, and itself
  double starts;            ///< of a cell, over other starts: noise

  double total() const { return group + simulator + group_simulator + policy + policy_simulator + starts; }
};

/// Spread of a table. `simulators` has a table of policies by starts for each simulator, all of the same shape, with at
/// least 2 simulators and 2 starts. `groups` has the group of each policy, numbers from 0 on without a gap: at least 2
/// groups, one of them with 2 policies.
Spread spreadOf(const std::vector<CrossedTable>& simulators, const std::vector<std::size_t>& groups);

}  // namespace sim2sim
