// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "answers.hpp"
#include "pusht_task/numbers.hpp"
#include "sim2sim_protocol/results/contrast.hpp"
#include "sim2sim_protocol/results/json.hpp"
#include "sim2sim_protocol/results/result_files.hpp"
#include "sim2sim_protocol/results/text.hpp"

namespace sim2sim {
namespace {

using nlohmann::json;

/// Probability, with a star where it is a finding.
std::string probabilityCell(const std::optional<double>& p) {
  return p ? probabilityText(*p) + (*p <= 1.0 - kConfidence ? " *" : "") : "";
}

std::string line(const std::string& name, const std::string& difference, const std::string& p,
                 const std::string& adjusted) {
  constexpr std::size_t kName = 44;
  constexpr std::size_t kDifference = 38;
  constexpr std::size_t kProbability = 11;
  return "  " + padded(name, kName) + padded(difference, kDifference) + padded(p, kProbability) + adjusted + "\n";
}

std::string listed(const std::vector<int>& episodes) {
  constexpr std::size_t kMost = 12;
  std::string text;
  for (std::size_t i = 0; i < std::min(kMost, episodes.size()); ++i) {
    text += (i == 0 ? "" : ", ") + std::to_string(episodes[i]);
  }
  return episodes.empty() ? "none" : text + (episodes.size() > kMost ? ", ..." : "");
}

/// Episodes in which only one run succeeds, `where`: " in the engine".
std::string changeText(const SuccessChange& change, const std::string& where) {
  return "  success lost" + where + " in " + std::to_string(change.lost.size()) + " episodes: " + listed(change.lost) +
         "\n  success gained" + where + " in " + std::to_string(change.gained.size()) + ": " + listed(change.gained) +
         "\n";
}

std::string transferText(const Outcomes& outcomes) {
  return outcomes.transfer ? percent(*outcomes.transfer, outcomes.transfer_interval) : "none";
}

std::string transfersText(const PolicyContrast& policies) {
  return "  transfer of the baseline " + transferText(policies.baseline) + ", of this one " +
         transferText(policies.other) + "\n";
}

json successJson(const SuccessChange& change) {
  return {{"both_succeed", change.counts.both},
          {"only_baseline_succeeds", change.lost},
          {"only_other_succeeds", change.gained},
          {"neither_succeeds", change.counts.neither}};
}

json transferJson(const Outcomes& outcomes) {
  return {{"value", readableJson(outcomes.transfer.value_or(kNoFigure))},
          {"interval", readableJson(outcomes.transfer_interval)}};
}

}  // namespace

json toJson(const RunResults& baseline, const std::vector<RunResults>& others, const std::vector<Contrast>& contrasts) {
  const Answer answer = answerOf(baseline, others, contrasts);
  json result = {
      {"format", kContrastFormat},
      {"confidence", kConfidence},
      {"headline", {{"question", answer.question}, {"answer", answer.answer}}},
      {"baseline", {{"title", contrasts.front().against}, {"simulator", baseline.metrics["simulators"]["engine"]}}},
      {"episodes", baseline.protocol.episodes},
      {"contrasts", json::array()}};
  if (contrasts.front().policies) {
    result["baseline"]["policy"] = baseline.policy();
  }
  for (std::size_t i = 0; i < contrasts.size(); ++i) {
    const Contrast& contrast = contrasts[i];
    json figures = json::object();
    for (const ContrastRow& row : contrast.rows) {
      const std::optional<Interval>& interval = row.difference.interval;
      figures[row.name + (row.unit.empty() ? "" : "_" + row.unit)] = {
          {"unit", row.unit},
          {"episodes", row.episodes},
          {"difference", row.difference.value},
          {"interval", interval ? json{interval->low, interval->high} : json()},
          {"p", orNull(row.difference.p)},
          {"adjusted_p", orNull(row.adjusted_p)},
          {"decided_after", orNull(row.decided_after)}};
    }
    json described = {
        {"title", contrast.title}, {"headline", sentenceOf(baseline, others[i], contrast)}, {"figures", figures}};
    if (contrast.policies) {
      described["policy"] = others[i].policy();
      described["reference"] = successJson(contrast.policies->reference);
    }
    if (contrast.has(kSuccessRow)) {
      described.update(successJson(contrast.engine));
    }
    if (contrast.has(kTransferRow)) {
      described["transfer"] = {{"baseline", transferJson(contrast.policies->baseline)},
                               {"other", transferJson(contrast.policies->other)}};
    }
    result["contrasts"].push_back(described);
  }
  return result;
}

std::string table(const RunResults& baseline, const std::vector<RunResults>& others,
                  const std::vector<Contrast>& contrasts) {
  constexpr int kRateDigits = 3;
  constexpr int kDigits = 4;
  std::string text = answerOf(baseline, others, contrasts).text() + "\n";
  for (const Contrast& contrast : contrasts) {
    text += contrast.title + "\n  against " + contrast.against + ", " + std::to_string(baseline.protocol.episodes) +
            " episodes\n" + line("", "difference", "p", "Holm");
    for (const ContrastRow& row : contrast.rows) {
      const int digits = row.unit.empty() ? kRateDigits : kDigits;
      text += line(row.name, signedText(row.difference.value, row.difference.interval, row.unit, digits),
                   probabilityCell(row.difference.p), probabilityCell(row.adjusted_p));
    }
    text += contrast.has(kTransferRow) ? transfersText(*contrast.policies) : "";
    text += contrast.policies ? changeText(contrast.policies->reference, " in the reference") : "";
    text += contrast.has(kSuccessRow) ? changeText(contrast.engine, contrast.policies ? " in the engine" : "") : "";
  }
  return text + "(in brackets " + pusht::fixedText(100.0 * kConfidence, 0) +
         " % intervals of each difference alone; Holm: p corrected for the number of figures above; * at most 0.05)\n";
}

}  // namespace sim2sim
