// SPDX-License-Identifier: BSD-3-Clause
#include "sim2sim_protocol/results/contrast.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <optional>
#include <string>

#include "answers.hpp"
#include "pusht_task/error.hpp"
#include "sim2sim_protocol/episode.hpp"
#include "sim2sim_protocol/results/metrics.hpp"
#include "sim2sim_protocol/results/summary.hpp"
#include "sim2sim_statistics/repeats.hpp"
#include "sim2sim_statistics/tails.hpp"
#include "starts.hpp"

namespace sim2sim {
namespace {

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

SuccessChange changeIn(const RunResults& baseline, const RunResults& other, std::size_t rollout) {
  SuccessChange change{};
  for (std::size_t i = 0; i < baseline.episodes.size(); ++i) {
    const bool before = baseline.episodes[i].rollouts[rollout].success;
    const bool now = other.episodes[i].rollouts[rollout].success;
    change.counts.add(before, now);
    if (before != now) {
      (now ? change.gained : change.lost).push_back(baseline.episodes[i].index);
    }
  }
  return change;
}

/// Number of episodes after which the success rates of two runs are known to differ, if watched.
std::optional<int> decidedAfter(const RunResults& baseline, const RunResults& other, std::size_t rollout) {
  AnyDifference watched;
  for (std::size_t i = 0; i < baseline.episodes.size(); ++i) {
    watched.add(baseline.episodes[i].rollouts[rollout].success, other.episodes[i].rollouts[rollout].success);
  }
  return watched.decidedAfter();
}

ContrastRow successRow(const char* name, const RunResults& baseline, const RunResults& other, std::size_t rollout,
                       const PairTable& counts) {
  ContrastRow row{name, "", counts.pairs(), {}};
  if (baseline.protocol.repeats == 1) {
    row.difference = rateDifference(counts);
    row.decided_after = decidedAfter(baseline, other, rollout);
  } else {
    row.difference =
        repeatedDifference(pairsByStart(baseline.protocol, baseline.episodes, rollout, other.episodes, rollout));
  }
  return row;
}

/// Successes of both simulators by start.
std::vector<PairTable> transferTables(const RunResults& run) {
  return pairsByStart(run.protocol, run.episodes, kReferenceClosed, run.episodes, kEngineClosed);
}

ContrastRow transferRow(const RunResults& baseline, const RunResults& other) {
  return {kTransferRow, "", static_cast<int>(baseline.episodes.size()),
          differenceOfRatios(transferTables(baseline), transferTables(other))};
}

Outcomes outcomesIn(const RunResults& run) { return outcomesOf(run.protocol, run.episodes, kEngineClosed); }

/// Two policies in the reference alone.
Contrast contrastAlone(const RunResults& baseline, const RunResults& other) {
  Contrast contrast;
  contrast.policies = PolicyContrast{changeIn(baseline, other, kReferenceClosed), {}, {}};
  contrast.rows = {
      successRow(kReferenceSuccessRow, baseline, other, kReferenceClosed, contrast.policies->reference.counts)};
  return contrast;
}

Contrast contrastOf(const RunResults& baseline, const RunResults& other, Pairing pairing) {
  if (baseline.protocol.alone) {
    return contrastAlone(baseline, other);
  }
  Contrast contrast;
  contrast.engine = changeIn(baseline, other, kEngineClosed);
  const ContrastRow success = successRow(kSuccessRow, baseline, other, kEngineClosed, contrast.engine.counts);
  if (pairing == Pairing::kPolicies) {
    const SuccessChange home = changeIn(baseline, other, kReferenceClosed);
    contrast.rows = {successRow(kReferenceSuccessRow, baseline, other, kReferenceClosed, home.counts), success,
                     transferRow(baseline, other)};
    contrast.policies = PolicyContrast{home, outcomesIn(baseline), outcomesIn(other)};
  } else {
    contrast.rows = {success};
  }
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

}  // namespace

bool Contrast::has(const std::string& name) const {
  return std::any_of(rows.begin(), rows.end(), [&](const ContrastRow& row) { return row.name == name; });
}

const ContrastRow& Contrast::row(const std::string& name) const {
  return *std::find_if(rows.begin(), rows.end(), [&](const ContrastRow& row) { return row.name == name; });
}

std::vector<Contrast> contrastsOf(const RunResults& baseline, const std::vector<RunResults>& others) {
  std::vector<Contrast> contrasts;
  std::optional<Pairing> pairing;
  for (const RunResults& other : others) {
    const Pairing of_other = pairingOf(baseline, other);
    if (pairing.value_or(of_other) != of_other) {
      throw pusht::InvalidInput(other.folder.string() + ": differs from " + baseline.folder.string() + " in the " +
                                (of_other == Pairing::kPolicies ? "policy" : "engine") +
                                ", others do not; all must differ in the same");
    }
    pairing = of_other;
    contrasts.push_back(contrastOf(baseline, other, of_other));
  }
  const std::vector<RunResults> runs = allOf(baseline, others);
  const std::vector<std::string> titles = pairing == Pairing::kPolicies ? policyTitles(runs) : titlesOf(runs);
  for (std::size_t i = 0; i < contrasts.size(); ++i) {
    contrasts[i].title = titles[i + 1];
    contrasts[i].against = titles.front();
  }
  adjust(contrasts);
  return contrasts;
}

}  // namespace sim2sim
