// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstddef>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pusht_task/error.hpp"
#include "sim2sim_protocol/results/json.hpp"
#include "sim2sim_protocol/results/matrix.hpp"
#include "sim2sim_protocol/results/matrix_files.hpp"
#include "sim2sim_protocol/results/text.hpp"

namespace sim2sim {
namespace {

using nlohmann::json;

std::size_t policyIn(const Matrix& matrix, const std::string& name) {
  const auto place = std::find_if(matrix.policies.begin(), matrix.policies.end(),
                                  [&](const MatrixPolicy& policy) { return policy.name == name; });
  if (place == matrix.policies.end()) {
    throw pusht::InvalidInput("policy " + name + ": must be one of the matrix, as its plan names it");
  }
  return static_cast<std::size_t>(place - matrix.policies.begin());
}

PolicyPair pairIn(const Matrix& matrix, std::size_t simulator, std::size_t first, std::size_t second) {
  PolicyPair pair{simulator, first, second, {}, {}};
  const std::vector<bool>& one = matrix.cells[first][simulator]->successes;
  const std::vector<bool>& other = matrix.cells[second][simulator]->successes;
  for (std::size_t episode = 0; episode < one.size(); ++episode) {
    pair.successes.add(one[episode], other[episode]);
  }
  pair.difference = rateDifference(pair.successes);
  return pair;
}

void adjust(std::vector<PolicyPair>& pairs) {
  std::vector<double> family;
  std::transform(pairs.begin(), pairs.end(), std::back_inserter(family),
                 [](const PolicyPair& pair) { return *pair.difference.p; });
  const std::vector<double> adjusted = holm(family);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    pairs[i].adjusted_p = adjusted[i];
  }
}

}  // namespace

std::vector<PolicyPair> pairsOf(const Matrix& matrix, const std::vector<std::string>& policies) {
  std::vector<std::size_t> wanted;
  for (const std::string& name : policies) {
    const std::size_t policy = policyIn(matrix, name);
    if (std::find(wanted.begin(), wanted.end(), policy) != wanted.end()) {
      throw pusht::InvalidInput("policy " + name + ": must be named once");
    }
    wanted.push_back(policy);
  }
  if (wanted.size() == 1) {
    throw pusht::InvalidInput("policy " + policies.front() + ": is alone; name two or more");
  }
  std::vector<PolicyPair> pairs;
  for (std::size_t simulator = 0; simulator < matrix.simulators.size(); ++simulator) {
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      for (std::size_t j = i + 1; j < wanted.size(); ++j) {
        if (matrix.cells[wanted[i]][simulator] && matrix.cells[wanted[j]][simulator]) {
          pairs.push_back(pairIn(matrix, simulator, wanted[i], wanted[j]));
        }
      }
    }
  }
  adjust(pairs);
  return pairs;
}

json toJson(const Matrix& matrix, const std::vector<PolicyPair>& pairs) {
  json list = json::array();
  for (const PolicyPair& pair : pairs) {
    list.push_back({{"simulator", matrix.simulators[pair.simulator].name},
                    {"first", matrix.policies[pair.first].name},
                    {"second", matrix.policies[pair.second].name},
                    {"both_succeed", pair.successes.both},
                    {"only_first_succeeds", pair.successes.first_only},
                    {"only_second_succeeds", pair.successes.second_only},
                    {"neither_succeeds", pair.successes.neither},
                    {"difference", figureJson(pair.difference)},
                    {"p", orNull(pair.difference.p)},
                    {"adjusted_p", orNull(pair.adjusted_p)}});
  }
  return list;
}

std::string table(const Matrix& matrix, const std::vector<PolicyPair>& pairs) {
  if (pairs.empty()) {
    return "";
  }
  constexpr int kDigits = 3;
  std::vector<std::vector<std::string>> rows = {
      {"simulator", "second - first", "difference of success", "p", "Holm", "only first, only second"}};
  for (const PolicyPair& pair : pairs) {
    const bool is_finding = *pair.adjusted_p <= 1.0 - kConfidence;
    rows.push_back({matrix.simulators[pair.simulator].name,
                    matrix.policies[pair.second].name + " - " + matrix.policies[pair.first].name,
                    signedText(pair.difference.value, pair.difference.interval, "", kDigits),
                    probabilityText(*pair.difference.p), probabilityText(*pair.adjusted_p) + (is_finding ? " *" : ""),
                    std::to_string(pair.successes.first_only) + ", " + std::to_string(pair.successes.second_only)});
  }
  return "\npolicies start by start; intervals of each difference alone, over further starts; Holm: over these " +
         std::to_string(pairs.size()) + " pairs, * at most 0.05\n" + aligned(rows);
}

}  // namespace sim2sim
