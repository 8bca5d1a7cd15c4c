// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/hypotheses_files.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <nlohmann/json.hpp>

#include "pusht_task/joined.hpp"
#include "sim2sim_protocol/results/json.hpp"
#include "sim2sim_protocol/results/text.hpp"

namespace sim2sim {

using nlohmann::json;

namespace {

constexpr std::array kSides = {"above", "below", "within"};
constexpr std::array kHypothesisVerdicts = {"holds", "contradicted", "not shown"};

template <class Enum, std::size_t kCount>
const char* nameOf(Enum value, const std::array<const char*, kCount>& names) {
  return names.at(static_cast<std::size_t>(value));
}

json askedJson(const GroupDifference& difference) {
  return {{"more", difference.more},
          {"less", difference.less},
          {"simulator", difference.simulator},
          {"figure", difference.figure},
          {"paired", difference.paired}};
}

json askedJson(const GroupRanking& ranking) {
  return {{"ranking", ranking.groups}, {"here", ranking.here}, {"there", ranking.there}, {"figure", "kendall"}};
}

json resultJson(const HypothesisResult& result) {
  const Hypothesis& hypothesis = result.hypothesis;
  json entry = std::visit([](const auto& figure) { return askedJson(figure); }, hypothesis.figure);
  entry.update(figureJson(result.found));
  entry.update({{"name", hypothesis.name},
                {"side", nameOf(hypothesis.side, kSides)},
                {"margin", hypothesis.margin},
                {"p", orNull(result.found.p)},
                {"adjusted_p", orNull(result.adjusted_p)},
                {"verdict", nameOf(result.verdict, kHypothesisVerdicts)}});
  return entry;
}

std::string figureText(const GroupDifference& difference) {
  return difference.figure + " in " + difference.simulator + ", " + difference.more + " - " + difference.less;
}

std::string figureText(const GroupRanking& ranking) {
  return "Kendall's tau of " + ranking.here + " and " + ranking.there + ", " + pusht::joined(ranking.groups);
}

}  // namespace

json toJson(const std::vector<HypothesisResult>& hypotheses) {
  json tested = json::array();
  std::transform(hypotheses.begin(), hypotheses.end(), std::back_inserter(tested), resultJson);
  return tested;
}

std::string table(const std::vector<HypothesisResult>& hypotheses) {
  if (hypotheses.empty()) {
    return "";
  }
  constexpr int kDigits = 4;
  std::string text =
      "\nhypotheses; intervals over further trainings and starts, those of rankings over further policies and starts\n";
  for (const HypothesisResult& result : hypotheses) {
    const Hypothesis& hypothesis = result.hypothesis;
    text += hypothesis.name + ": " + nameOf(result.verdict, kHypothesisVerdicts) + "\n  " +
            std::visit([](const auto& figure) { return figureText(figure); }, hypothesis.figure) + ": " +
            signedText(result.found.value, result.found.interval, "", kDigits) +
            (result.adjusted_p ? ", p after Holm " + probabilityText(*result.adjusted_p) : "") + "\n";
  }
  return text;
}

}  // namespace sim2sim
