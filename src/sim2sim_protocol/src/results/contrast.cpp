// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/contrast.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <nlohmann/json.hpp>

#include "answers.hpp"
#include "pusht_task/numbers.hpp"
#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/results/json.hpp"
#include "sim2sim_protocol/results/metrics.hpp"
#include "sim2sim_protocol/results/result_files.hpp"
#include "sim2sim_protocol/results/summary.hpp"
#include "sim2sim_protocol/results/text.hpp"
#include "sim2sim_statistics/tails.hpp"
#include "starts.hpp"

namespace sim2sim {
namespace {

using nlohmann::json;

/// The figures that are contrasted: those that depend on the engine.
bool isContrasted(const Protocol& protocol, std::size_t rollout, const Quantity& quantity) {
  const std::optional<Probe> probe = protocol.probeOf(rollout);
  const bool of_engine = probe ? probe->world == ProbedWorld::kEngine : rollout != kReferenceClosed;
  const bool of_null = std::any_of(kDivergencePairs.begin(), kDivergencePairs.end(), [&](const DivergencePair& pair) {
    return std::string(pair.null_model) == quantity.name;
  });
  return of_engine && !of_null && protocol.has(rollout, quantity.scope);
}

/// The larger of the two runs' extremes; none if either has none.
std::optional<double> extremeOf(const RunResults& one, const RunResults& other, const FigureIndex& figure) {
  const std::optional<double> first = extremeOf(one.episodes, figure);
  const std::optional<double> second = extremeOf(other.episodes, figure);
  return first && second ? std::max(first, second) : std::nullopt;
}

/// Row of a figure, of runs that have a result for each start; `episodes` have the figure.
ContrastRow rowOf(const RunResults& baseline, const RunResults& other, const FigureIndex& place, std::size_t episodes) {
  const auto [rollout, quantity] = place;
  const std::vector<double> differences = differencesOf(other.episodes, place, baseline.episodes, place);
  const std::optional<double> extreme = extremeOf(baseline, other, place);
  Difference difference = pairedDifference(differences, extreme);
  DifferenceSequence watched;
  for (const double difference : differences) {
    watched.add(difference);
  }
  bool is_decidable = baseline.protocol.repeats == 1 && (!extreme || !isCarriedByFew(differences, *extreme));
  if (!kQuantities[quantity].hasIntervals()) {  // whether few episodes carry it is not known
    difference = {difference.value, std::nullopt, std::nullopt};
    is_decidable = false;
  }
  return {metricName(baseline.protocol.rolloutNames()[rollout], kQuantities[quantity]),
          kQuantities[quantity].unit,
          static_cast<int>(episodes),
          difference,
          {},
          is_decidable ? watched.decidedAfter() : std::nullopt};
}

/// The results by start.
RunResults byStarts(RunResults results) {
  results.episodes = meansOfStarts(results.protocol, results.episodes);
  return results;
}

Contrast contrastOf(const RunResults& baseline, const RunResults& other) {
  Contrast contrast;
  AnyDifference watched;
  for (std::size_t i = 0; i < baseline.episodes.size(); ++i) {
    const bool before = baseline.episodes[i].rollouts[kEngineClosed].success;
    const bool now = other.episodes[i].rollouts[kEngineClosed].success;
    watched.add(before, now);
    if (before != now) {
      (now ? contrast.gained : contrast.lost).push_back(baseline.episodes[i].index);
    }
  }
  contrast.successes = watched.counts();
  ContrastRow success{kSuccessRow, "", contrast.successes.pairs(), {}};
  if (baseline.protocol.repeats == 1) {
    success.difference = {contrast.successes.difference(), tangoInterval(contrast.successes),
                          mcnemarMidP(contrast.successes)};
    success.decided_after = watched.decidedAfter();
  } else {
    success.difference = repeatedDifference(
        pairsByStart(baseline.protocol, baseline.episodes, kEngineClosed, other.episodes, kEngineClosed));
  }
  contrast.rows.push_back(success);
  const RunResults baseline_starts = byStarts(baseline);
  const RunResults other_starts = byStarts(other);
  const std::size_t rollouts = baseline.protocol.rolloutNames().size();
  for (std::size_t rollout = 0; rollout < rollouts; ++rollout) {
    for (std::size_t i = 0; i < kQuantities.size(); ++i) {
      if (isContrasted(baseline.protocol, rollout, kQuantities[i])) {
        const FigureIndex place{rollout, i};
        const std::size_t episodes = differencesOf(other.episodes, place, baseline.episodes, place).size();
        contrast.rows.push_back(rowOf(baseline_starts, other_starts, place, episodes));
      }
    }
  }
  return contrast;
}

/// Sets the adjusted p-values.
void adjust(std::vector<Contrast>& contrasts) {
  std::vector<double> family;
  for (const Contrast& contrast : contrasts) {
    for (const ContrastRow& row : contrast.rows) {
      if (row.difference.p) {
        family.push_back(*row.difference.p);
      }
    }
  }
  const std::vector<double> adjusted = holm(family);
  auto next = adjusted.begin();
  for (Contrast& contrast : contrasts) {
    for (ContrastRow& row : contrast.rows) {
      if (row.difference.p) {
        row.adjusted_p = *next++;
      }
    }
  }
}

/// With a star where that is a finding.
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

}  // namespace

std::vector<Contrast> contrastsOf(const RunResults& baseline, const std::vector<RunResults>& others) {
  std::vector<Contrast> contrasts;
  for (const RunResults& other : others) {
    requirePairs(baseline, other);
    contrasts.push_back(contrastOf(baseline, other));
  }
  const std::vector<std::string> titles = titlesOf(allOf(baseline, others));
  for (std::size_t i = 0; i < contrasts.size(); ++i) {
    contrasts[i].title = titles[i + 1];
  }
  adjust(contrasts);
  return contrasts;
}

json toJson(const RunResults& baseline, const std::vector<RunResults>& others, const std::vector<Contrast>& contrasts) {
  const Answer answer = answerOf(baseline, others, contrasts);
  const std::string title = titlesOf(allOf(baseline, others)).front();
  json result = {{"format", kContrastFormat},
                 {"confidence", kConfidence},
                 {"headline", {{"question", answer.question}, {"answer", answer.answer}}},
                 {"baseline", {{"title", title}, {"simulator", baseline.metrics["simulators"]["engine"]}}},
                 {"episodes", baseline.protocol.episodes},
                 {"contrasts", json::array()}};
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
    result["contrasts"].push_back({{"title", contrast.title},
                                   {"headline", sentenceOf(baseline, others[i], contrast)},
                                   {"both_succeed", contrast.successes.both},
                                   {"only_baseline_succeeds", contrast.lost},
                                   {"only_other_succeeds", contrast.gained},
                                   {"neither_succeeds", contrast.successes.neither},
                                   {"figures", figures}});
  }
  return result;
}

std::string table(const RunResults& baseline, const std::vector<RunResults>& others,
                  const std::vector<Contrast>& contrasts) {
  constexpr int kRateDigits = 3;
  constexpr int kDigits = 4;
  const std::string against = titlesOf(allOf(baseline, others)).front();
  std::string text = answerOf(baseline, others, contrasts).text() + "\n";
  for (const Contrast& contrast : contrasts) {
    text += contrast.title + "\n  against " + against + ", " + std::to_string(contrast.successes.pairs()) +
            " episodes\n" + line("", "difference", "p", "Holm");
    for (const ContrastRow& row : contrast.rows) {
      const int digits = row.unit.empty() ? kRateDigits : kDigits;
      text += line(row.name, signedText(row.difference.value, row.difference.interval, row.unit, digits),
                   probabilityCell(row.difference.p), probabilityCell(row.adjusted_p));
    }
    text += "  success lost in " + std::to_string(contrast.lost.size()) + " episodes: " + listed(contrast.lost) +
            "\n  success gained in " + std::to_string(contrast.gained.size()) + ": " + listed(contrast.gained) + "\n";
  }
  return text + "(in brackets " + pusht::fixedText(100.0 * kConfidence, 0) +
         " % intervals of each difference alone; Holm: p corrected for the number of figures above; * at most 0.05)\n";
}

}  // namespace sim2sim
