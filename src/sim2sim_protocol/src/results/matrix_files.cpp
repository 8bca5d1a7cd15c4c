// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/matrix_files.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "pusht_task/joined.hpp"
#include "pusht_task/numbers.hpp"
#include "sim2sim_protocol/results/json.hpp"
#include "sim2sim_protocol/results/result_files.hpp"
#include "sim2sim_protocol/results/text.hpp"
#include "sim2sim_statistics/crossed.hpp"

namespace sim2sim {

using nlohmann::json;

namespace {

template <class Estimates>
json divergencesJson(const Estimates& estimates) {
  json divergences = json::object();
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    const Quantity& quantity = kQuantities[quantityIndex(kMatrixDivergences[i])];
    json& divergence = divergences[quantity.name] = figureJson(estimates[i]);
    divergence["unit"] = quantity.unit;
  }
  return divergences;
}

/// "1" for each episode in which the policy succeeds, "0" for the others.
std::string successText(const std::vector<bool>& successes) {
  std::string text;
  for (const bool success : successes) {
    text += success ? '1' : '0';
  }
  return text;
}

json cellJson(const MatrixCell& cell) {
  return {{"row", cell.sweep_row},
          {"success_by_episode", successText(cell.successes)},
          {"successes", cell.success.successes},
          {"success_rate", readable(cell.success.rate)},
          {"success_interval", readableJson(cell.success.interval)},
          {"transfer", readableJson(cell.transfer.value_or(kNoFigure))},
          {"transfer_interval", readableJson(cell.transfer_interval)},
          {"divergence", divergencesJson(cell.mean_divergences)}};
}

json cellJson(const GroupCell& cell) {
  return {{"policy_count", cell.policy_count},
          {"success_rate", figureJson(cell.success)},
          {"transfer", figureJson(cell.transfer)},
          {"between_policies", readableJson(cell.between_policies)},
          {"divergence", divergencesJson(cell.divergences)}};
}

constexpr std::array kVerdicts = {"preserved", "reversed", "cannot say"};

const char* verdictText(const MatrixRanking& ranking) {
  return kVerdicts.at(static_cast<std::size_t>(ranking.comparison.verdict));
}

json rankingJson(const MatrixRanking& ranking) {
  const RankingComparison& comparison = ranking.comparison;
  json agreement = json::array();
  for (const PairAgreement& bin : comparison.agreement) {
    json share = figureJson(bin.share);
    share.update({{"from", bin.from}, {"to", bin.to}, {"pairs", bin.pairs}});
    agreement.push_back(share);
  }
  return {{"reference", ranking.reference},
          {"test", ranking.test},
          {"policy_count", ranking.policy_count},
          {"verdict", verdictText(ranking)},
          {"kendall", figureJson(comparison.kendall)},
          {"spearman", figureJson(comparison.spearman)},
          {"pearson", figureJson(comparison.pearson)},
          {"mean_maximum_rank_violation", figureJson(comparison.violation)},
          {"reference_reliability", readableJson(comparison.reference_reliability)},
          {"test_reliability", readableJson(comparison.test_reliability)},
          {"agreement", agreement}};
}

/// Part of a spread by its name.
struct SpreadSource {
  const char* name;
  double Spread::*variance;
};

constexpr std::array kSpreadSources = {
    SpreadSource{"simulator", &Spread::simulator},
    SpreadSource{"group", &Spread::group},
    SpreadSource{"group x simulator", &Spread::group_simulator},
    SpreadSource{"policy", &Spread::policy},
    SpreadSource{"policy x simulator", &Spread::policy_simulator},
    SpreadSource{"starts", &Spread::starts},
};

json spreadJson(const MatrixSpread& spread) {
  json sources = json::array();
  for (const SpreadSource& source : kSpreadSources) {
    const double variance = spread.spread.*source.variance;
    sources.push_back({{"source", source.name},
                       {"standard_deviation", readable(std::sqrt(variance))},
                       {"share", readableJson(variance / spread.spread.total())}});
  }
  return {{"figure", spread.figure}, {"simulators", spread.simulators}, {"sources", sources}};
}

template <class Cells>
json cellsJson(const Cells& cells) {
  json list = json::array();
  for (const auto& cell : cells) {
    list.push_back(cell ? cellJson(*cell) : json());
  }
  return list;
}

constexpr int kRateDigits = 2;

std::string transferText(double transfer, const std::optional<Interval>& interval) {
  return std::isnan(transfer) ? "" : "  " + percent(transfer, interval);
}

std::vector<std::string> heading(const Matrix& matrix, const std::string& first) {
  std::vector<std::string> names = {first};
  for (const MatrixSimulator& simulator : matrix.simulators) {
    names.push_back(simulator.name);
  }
  return names;
}

std::string policyTable(const Matrix& matrix) {
  std::vector<std::vector<std::string>> rows = {heading(matrix, "policy")};
  for (std::size_t i = 0; i < matrix.policies.size(); ++i) {
    rows.push_back({matrix.policies[i].name});
    for (std::size_t simulator = 0; simulator < matrix.simulators.size(); ++simulator) {
      const std::optional<MatrixCell>& cell = matrix.cells[i][simulator];
      rows.back().push_back(!cell ? "-"
                                  : valueText(cell->success.rate, cell->success.interval, kRateDigits) +
                                        (simulator == matrix.policies[i].reference ? " reference"
                                         : cell->transfer ? transferText(*cell->transfer, cell->transfer_interval)
                                                          : ""));
    }
  }
  return "success in " + std::to_string(matrix.episodes) +
         " episodes, and transfer from the policy's reference; intervals over further starts\n" + aligned(rows);
}

std::string groupTable(const Matrix& matrix) {
  if (matrix.groups.empty()) {
    return "";
  }
  std::vector<std::vector<std::string>> rows = {heading(matrix, "group")};
  for (const MatrixGroup& group : matrix.groups) {
    rows.push_back({group.name + " (" + std::to_string(group.policies.size()) + ")"});
    for (const std::optional<GroupCell>& cell : group.cells) {
      rows.back().push_back(!cell ? "-"
                                  : valueText(cell->success.value, cell->success.interval, kRateDigits) +
                                        transferText(cell->transfer.value, cell->transfer.interval));
    }
  }
  const bool has_one = std::any_of(matrix.groups.begin(), matrix.groups.end(),
                                   [](const MatrixGroup& group) { return group.policies.size() == 1; });
  return "\nthe same for groups of policies; intervals over further trainings and starts (none below " +
         std::to_string(kFewestRows) + " policies" + (has_one ? "; of a group of one over starts alone" : "") + ")\n" +
         aligned(rows);
}

/// Mean divergence of replays of each group in each simulator, a table for each of kMatrixDivergences.
std::string divergenceTables(const Matrix& matrix) {
  if (matrix.groups.empty()) {
    return "";
  }
  constexpr int kDigits = 4;
  std::string text;
  for (std::size_t i = 0; i < kMatrixDivergences.size(); ++i) {
    const Quantity& quantity = kQuantities[quantityIndex(kMatrixDivergences[i])];
    std::vector<std::vector<std::string>> rows = {heading(matrix, "group")};
    for (const MatrixGroup& group : matrix.groups) {
      rows.push_back({group.name});
      for (const std::optional<GroupCell>& cell : group.cells) {
        const Estimate divergence = cell ? cell->divergences.at(i) : Estimate{};
        rows.back().push_back(std::isnan(divergence.value) ? "-"
                                                           : valueText(divergence.value, divergence.interval, kDigits));
      }
    }
    text += std::string("\n") + quantity.name + " [" + quantity.unit +
            "] of replays of the reference's actions; intervals likewise (none where few starts carry the mean)\n" +
            aligned(rows);
  }
  return text;
}

std::string figureText(const Estimate& estimate) {
  return std::isnan(estimate.value) ? "none" : valueText(estimate.value, estimate.interval, kRateDigits);
}

std::string rankingTable(const Matrix& matrix) {
  if (matrix.rankings.empty()) {
    return "";
  }
  std::vector<std::vector<std::string>> rows = {
      {"here", "there", "policies", "Kendall", "Pearson", "rank violation", "better here, better there*", "ranking"}};
  for (const MatrixRanking& ranking : matrix.rankings) {
    const auto is_here = [&](const MatrixPolicy& policy) { return policy.reference == ranking.reference; };
    if (std::none_of(matrix.policies.begin(), matrix.policies.end(), is_here)) {
      continue;  // matrix.json has it
    }
    const RankingComparison& comparison = ranking.comparison;
    const PairAgreement& farthest = comparison.agreement.back();
    rows.push_back({matrix.simulators[ranking.reference].name, matrix.simulators[ranking.test].name,
                    std::to_string(ranking.policy_count), figureText(comparison.kendall),
                    figureText(comparison.pearson), figureText(comparison.violation), figureText(farthest.share),
                    verdictText(ranking)});
  }
  return "\ndoes the ranking of the policies survive? Intervals over further policies and starts, each on its own "
         "(none "
         "below " +
         std::to_string(kFewestPolicies) + " policies, or where they are too much alike)\n" + aligned(rows) +
         "* of pairs whose success differs by " + pusht::fixedText(kAgreementBins.back(), 1) +
         " or more here; a tie counts half\n";
}

std::string spreadTable(const Matrix& matrix) {
  if (matrix.spreads.empty()) {
    return "";
  }
  std::vector<std::vector<std::string>> rows = {{"figure", "cells' deviation"}};
  for (const SpreadSource& source : kSpreadSources) {
    rows.front().emplace_back(source.name);
  }
  rows.front().emplace_back("in");
  for (const MatrixSpread& spread : matrix.spreads) {
    const double total = spread.spread.total();
    rows.push_back({spread.figure, pusht::fixedText(readable(std::sqrt(total)), kRateDigits + 2)});
    for (const SpreadSource& source : kSpreadSources) {
      rows.back().push_back(total > 0.0 ? percent(spread.spread.*source.variance / total) : "none");
    }
    std::vector<std::string> names;
    std::transform(spread.simulators.begin(), spread.simulators.end(), std::back_inserter(names),
                   [&](std::size_t simulator) { return matrix.simulators[simulator].name; });
    rows.back().push_back(pusht::joined(names));
  }
  return "\nwhat makes the cells differ? Shares of the variance, among these groups and simulators\n" + aligned(rows);
}

}  // namespace

json toJson(const Matrix& matrix) {
  json simulators = json::array();
  for (const MatrixSimulator& simulator : matrix.simulators) {
    simulators.push_back({{"name", simulator.name}, {"title", simulator.title}});
  }
  json policies = json::array();
  for (std::size_t i = 0; i < matrix.policies.size(); ++i) {
    const MatrixPolicy& policy = matrix.policies[i];
    policies.push_back({{"policy", policy.name},
                        {"group", policy.group},
                        {"reference", policy.reference},
                        {"cells", cellsJson(matrix.cells[i])}});
  }
  json groups = json::array();
  for (const MatrixGroup& group : matrix.groups) {
    groups.push_back({{"group", group.name}, {"policies", group.policies}, {"cells", cellsJson(group.cells)}});
  }
  json rankings = json::array();
  std::transform(matrix.rankings.begin(), matrix.rankings.end(), std::back_inserter(rankings), rankingJson);
  json spreads = json::array();
  std::transform(matrix.spreads.begin(), matrix.spreads.end(), std::back_inserter(spreads), spreadJson);
  return {{"format", kMatrixFormat},
          {"confidence", kConfidence},
          {"episodes", matrix.episodes},
          {"first_episode", matrix.first_episode},
          {"simulators", simulators},
          {"policies", policies},
          {"groups", groups},
          {"rankings", rankings},
          {"spreads", spreads}};
}

std::string toCsv(const Matrix& matrix) {
  std::ostringstream csv;
  csv << "policy,group,reference,simulator,row,episodes,successes,success_rate,success_rate_low,success_rate_high,"
         "transfer,"
         "transfer_low,transfer_high";
  for (const char* name : kMatrixDivergences) {
    const std::string column = std::string(name) + "_" + kQuantities[quantityIndex(name)].unit;
    csv << ',' << column << ',' << column << "_low," << column << "_high";
  }
  csv << '\n';
  for (std::size_t i = 0; i < matrix.policies.size(); ++i) {
    const MatrixPolicy& policy = matrix.policies[i];
    for (std::size_t simulator = 0; simulator < matrix.simulators.size(); ++simulator) {
      const std::optional<MatrixCell>& cell = matrix.cells[i][simulator];
      if (!cell) {
        continue;
      }
      csv << csvText(policy.name) << ',' << csvText(policy.group) << ','
          << csvText(matrix.simulators[policy.reference].name) << ',' << csvText(matrix.simulators[simulator].name)
          << ',' << cell->sweep_row << ',' << matrix.episodes << ',' << cell->success.successes << ','
          << csvFigure(cell->success.rate, cell->success.interval) << ','
          << csvFigure(cell->transfer.value_or(kNoFigure), cell->transfer_interval);
      for (const Estimate& divergence : cell->mean_divergences) {
        csv << ',' << csvFigure(divergence.value, divergence.interval);
      }
      csv << '\n';
    }
  }
  return csv.str();
}

std::string table(const Matrix& matrix) {
  return policyTable(matrix) + groupTable(matrix) + divergenceTables(matrix) + spreadTable(matrix) +
         rankingTable(matrix);
}

}  // namespace sim2sim
