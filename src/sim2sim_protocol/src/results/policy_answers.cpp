// SPDX-License-Identifier: BSD-3-Clause
// Answers about policies over the same starts in one pair of simulators.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <iterator>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "answers.hpp"
#include "pusht_task/joined.hpp"
#include "pusht_task/numbers.hpp"
#include "sim2sim_protocol/results/headline.hpp"
#include "sim2sim_protocol/results/run_configuration.hpp"
#include "sim2sim_protocol/results/text.hpp"
#include "sim2sim_statistics/planning.hpp"

namespace sim2sim {
namespace {

namespace fs = std::filesystem;

constexpr double kPoints = 100.0;    ///< of a rate of 1
constexpr double kWorthwhile = 5.0;  ///< [points] the difference for which the sentence plans

/// The last `parts` parts of a path.
std::string endOf(const std::string& path, std::size_t parts) {
  const fs::path whole(path);
  const std::vector<fs::path> names(whole.begin(), whole.end());
  fs::path end;
  for (std::size_t i = names.size() - std::min(parts, names.size()); i < names.size(); ++i) {
    end /= names[i];
  }
  return end.string();
}

/// The shortest ends of the policies' paths that tell different ones apart.
std::vector<std::string> shortNames(const std::vector<RunResults>& runs) {
  constexpr std::size_t kMostParts = 32;
  for (std::size_t parts = 1; parts <= kMostParts; ++parts) {
    bool are_apart = true;
    for (const RunResults& one : runs) {
      are_apart = are_apart && std::none_of(runs.begin(), runs.end(), [&](const RunResults& other) {
                    return one.policy() != other.policy() && endOf(one.policy(), parts) == endOf(other.policy(), parts);
                  });
    }
    if (are_apart) {
      std::vector<std::string> names;
      std::transform(runs.begin(), runs.end(), std::back_inserter(names),
                     [parts](const RunResults& run) { return endOf(run.policy(), parts); });
      return names;
    }
  }
  std::vector<std::string> names;
  std::transform(runs.begin(), runs.end(), std::back_inserter(names),
                 [](const RunResults& run) { return run.policy(); });
  return names;
}

/// Value that distinguishes runs whose policies have the same name; empty if all have the same.
std::vector<std::string> apartBy(const std::vector<RunResults>& runs, std::string (*value)(const RunResults&)) {
  std::vector<std::string> values;
  std::transform(runs.begin(), runs.end(), std::back_inserter(values), value);
  const bool are_same = std::adjacent_find(values.begin(), values.end(), std::not_equal_to<>()) == values.end();
  return are_same ? std::vector<std::string>(runs.size()) : values;
}

/// "+3 points [-4, +10]"; with a digit where the interval is narrow, and where an end would round to 0.
std::string pointsText(const Difference& difference) {
  constexpr double kNarrow = 4.0;  // [points]
  const auto signed_number = [](double points, int digits) {
    return (points >= 0.0 ? "+" : "") + pusht::fixedText(points, digits);
  };
  const std::optional<Interval>& interval = difference.interval;
  const auto rounds_to_zero = [](double end) { return end != 0.0 && std::abs(kPoints * end) < 0.5; };
  const bool is_fine = interval && (kPoints * (interval->high - interval->low) < kNarrow ||
                                    rounds_to_zero(interval->low) || rounds_to_zero(interval->high));
  const int digits = is_fine ? 1 : 0;
  std::string text = signed_number(kPoints * difference.value, digits) + " points";
  if (interval) {
    text += " [" + signed_number(kPoints * interval->low, digits) + ", " +
            signed_number(kPoints * interval->high, digits) + "]";
  }
  return text;
}

/// "; 940 would show 5"; empty where that many or more were played, and where no number would.
std::string planText(const SuccessChange& change) {
  const double discordant = change.counts.discordant();
  if (discordant <= kWorthwhile / kPoints || change.counts.pairs() < kFewestEpisodes) {
    return "";
  }
  const std::optional<int> needed = episodesForRates(discordant, kWorthwhile / kPoints);
  return needed && *needed > change.counts.pairs()
             ? "; " + std::to_string(*needed) + " would show " + pusht::fixedText(kWorthwhile, 0)
             : "";
}

/// What was found of a row, after Holm.
enum class Found { kNothing, kWorse, kBetter };

Found foundIn(const ContrastRow& row) {
  return !row.isFinding() ? Found::kNothing : row.difference.value < 0.0 ? Found::kWorse : Found::kBetter;
}

/// ", after Holm p 0.07" of a difference that would be a finding on its own.
std::string holmText(const ContrastRow& row) {
  const bool by_chance = row.difference.p && *row.difference.p <= 1.0 - kConfidence && !row.isFinding();
  return by_chance ? ", after Holm p " + probabilityText(*row.adjusted_p) : "";
}

/// "In MuJoCo B is not shown to be better or worse than A: +3 points [-4, +10] over 200 starts; 940 would show 5."
std::string clauseOf(const std::string& simulator, const std::string& other, const std::string& baseline,
                     const ContrastRow& row, const SuccessChange& change, int repeats) {
  constexpr std::array kVerbs = {" is not shown to be better or worse than ", " is worse than ", " is better than "};
  const Found found = foundIn(row);
  std::string text = "In " + simulator + " " + other + kVerbs.at(static_cast<std::size_t>(found)) + baseline + ": " +
                     pointsText(row.difference) + holmText(row) + " over " +
                     std::to_string(change.counts.pairs() / repeats) + " starts";
  if (found == Found::kNothing && repeats == 1) {
    text += planText(change);
  }
  return text + ".";
}

std::string transferOf(const Outcomes& outcomes) { return percent(*outcomes.transfer, outcomes.transfer_interval); }

/// "Chipmunk keeps 83 % [71, 95] of A's success and 71 % [62, 80] of B's: -12 points [-26, +3], not shown to differ."
std::string transferClause(const std::string& engine, const std::string& baseline, const std::string& other,
                           const Contrast& contrast) {
  const PolicyContrast& policies = *contrast.policies;
  if (!policies.baseline.transfer || !policies.other.transfer) {
    return " There is no transfer of " + (policies.baseline.transfer ? other : baseline) +
           ", which never succeeds in the reference.";
  }
  const ContrastRow& row = contrast.row(kTransferRow);
  std::string name = engine;
  name[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(name[0])));
  return " " + name + " keeps " + transferOf(policies.baseline) + " of " + baseline + "'s success and " +
         transferOf(policies.other) + " of " + other + "'s: " + pointsText(row.difference) + holmText(row) +
         (row.isFinding() ? "." : ", not shown to differ.");
}

/// Names in a sentence of the two simulators.
struct Simulators {
  explicit Simulators(const RunResults& run) : reference(nameOf(run, "reference")), engine(nameOf(run, "engine")) {
    if (reference == engine) {
      reference = "the reference";
      engine = "the engine";
    }
  }

  static std::string nameOf(const RunResults& run, const char* role) {
    return inSentence(titleOf(simulatorFrom(run.metrics.at("simulators").at(role))));
  }

  std::string reference;
  std::string engine;
};

/// "In MuJoCo better: B and C; worse: D." of those that are; "In MuJoCo none is shown to be."
std::string changesIn(const std::string& simulator, const char* row, const std::vector<Contrast>& contrasts) {
  std::array<std::vector<std::string>, 3> names;
  for (const Contrast& contrast : contrasts) {
    names.at(static_cast<std::size_t>(foundIn(contrast.row(row)))).push_back(contrast.title);
  }
  const auto& [unknown, worse, better] = names;
  std::vector<std::string> parts;
  if (!better.empty()) {
    parts.push_back("better: " + pusht::joined(better));
  }
  if (!worse.empty()) {
    parts.push_back("worse: " + pusht::joined(worse));
  }
  if (!unknown.empty()) {
    parts.push_back(parts.empty() ? "none is shown to be better or worse" : "not shown: " + pusht::joined(unknown));
  }
  return "In " + simulator + " " + pusht::joined(parts, "; ") + ".";
}

}  // namespace

std::vector<std::string> policyTitles(const std::vector<RunResults>& runs) {
  std::vector<std::string> titles = shortNames(runs);
  const std::vector<std::string> executed = apartBy(
      runs, [](const RunResults& run) { return "execute " + run.metrics.value("execute", nlohmann::json(0)).dump(); });
  constexpr std::size_t kDigits = 8;  // of a SHA-256
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const bool has_namesake = std::any_of(runs.begin(), runs.end(), [&](const RunResults& other) {
      return other.policy() == runs[i].policy() && other.policy_sha256 != runs[i].policy_sha256;
    });
    titles[i] +=
        has_namesake && !runs[i].policy_sha256.empty() ? " (" + runs[i].policy_sha256.substr(0, kDigits) + ")" : "";
    titles[i] += executed[i].empty() ? "" : ", " + executed[i];
  }
  return titles;
}

std::string policySentence(const RunResults& baseline, const RunResults& other, const Contrast& contrast) {
  const std::vector<std::string> titles = policyTitles({baseline, other});
  const Simulators simulators(baseline);
  const int repeats = baseline.protocol.repeats;
  std::string at_home = clauseOf(simulators.reference, titles[1], titles[0], contrast.row(kReferenceSuccessRow),
                                 contrast.policies->reference, repeats);
  if (!contrast.has(kSuccessRow)) {
    return at_home;
  }
  return at_home + " " +
         clauseOf(simulators.engine, titles[1], titles[0], contrast.row(kSuccessRow), contrast.engine, repeats) +
         transferClause(simulators.engine, titles[0], titles[1], contrast);
}

Answer policyAnswer(const RunResults& baseline, const std::vector<RunResults>& others,
                    const std::vector<Contrast>& contrasts) {
  const std::vector<std::string> titles = policyTitles(allOf(baseline, others));
  if (others.size() == 1) {
    return {"Is " + titles[1] + " better than " + titles[0] + "?",
            policySentence(baseline, others.front(), contrasts.front())};
  }
  const Simulators simulators(baseline);
  return {"Which policies are better than " + titles[0] + "?",
          changesIn(simulators.reference, kReferenceSuccessRow, contrasts) +
              (baseline.protocol.alone ? "" : " " + changesIn(simulators.engine, kSuccessRow, contrasts))};
}

}  // namespace sim2sim
