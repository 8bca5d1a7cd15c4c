// SPDX-License-Identifier: BSD-3-Clause
#include "batch/plan.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "pusht_task/error.hpp"
#include "pusht_task/numbers.hpp"
#include "sim2sim_eval/interruption.hpp"
#include "sim2sim_protocol/results/json.hpp"
#include "sim2sim_protocol/results/result_files.hpp"
#include "sim2sim_protocol/results/summary.hpp"
#include "sim2sim_protocol/results/text.hpp"
#include "sim2sim_statistics/planning.hpp"
#include "sim2sim_statistics/ranking.hpp"

namespace sim2sim {
namespace {

/// Row of the plan: a difference that a run may show, and how much it varies from pair to pair.
struct PlannedDifference {
  std::string text;
  std::optional<double> deviation;   ///< standard deviation of paired differences; none for success, or too few pairs
  std::optional<double> discordant;  ///< share of pairs in which only one succeeds; none for divergences
  std::optional<double> wanted;      ///< difference that is to be shown
};

std::string significant(double value) {
  constexpr int kDigits = 2;
  return pusht::significantText(value, kDigits);
}

std::optional<double> deviationOf(const std::vector<double>& differences) {
  return differences.size() < 2 ? std::nullopt : std::optional(standardDeviation(differences));
}

std::vector<PlannedDifference> plannedDifferences(const PlanQuestions& questions, const RunResults& pilot,
                                                  const std::optional<RunResults>& other) {
  const std::array<std::pair<std::string, std::optional<double>>, 2> names = {
      std::make_pair("position divergence [m]", questions.position), {"angle divergence [rad]", questions.angle}};

  std::vector<PlannedDifference> planned;
  const auto success = [&](const std::string& text, const PairTable& table) {
    planned.push_back({text, {}, table.discordant(), questions.success});
  };
  if (!pilot.protocol.alone) {
    success("success, engine - reference", pairsOf(pilot.episodes, kReferenceClosed, pilot.episodes, kEngineClosed));
  }
  if (other && pairingOf(pilot, *other) == Pairing::kPolicies) {
    success("success in reference, other - pilot",
            pairsOf(pilot.episodes, kReferenceClosed, other->episodes, kReferenceClosed));
    if (pilot.protocol.alone) {
      return planned;
    }
    success("success in engine, other - pilot", pairsOf(pilot.episodes, kEngineClosed, other->episodes, kEngineClosed));
  } else if (other) {
    success("success, other - pilot", pairsOf(pilot.episodes, kEngineClosed, other->episodes, kEngineClosed));
  }
  for (std::size_t k = 0; k < kWholeEpisodePairs; ++k) {
    const FigureIndex divergence{kEngineReplay, quantityIndex(kDivergencePairs[k].divergence)};
    const FigureIndex null_model{kEngineReplay, quantityIndex(kDivergencePairs[k].null_model)};
    const auto spread = [&](const std::string& text, const std::vector<double>& differences) {
      planned.push_back({names.at(k).first + text, deviationOf(differences), {}, names.at(k).second});
    };
    spread(", against null model", differencesOf(pilot.episodes, divergence, pilot.episodes, null_model));
    if (other) {
      spread(", other - pilot", differencesOf(other->episodes, divergence, pilot.episodes, divergence));
    }
  }
  return planned;
}

/// Whether any pair of the pilot differs, so that a plan can be made.
bool isKnown(const PlannedDifference& planned) {
  return planned.deviation || (planned.discordant && *planned.discordant > 0.0);
}

/// Smallest difference that `episodes` episodes show; none if there is none, or nothing is known.
std::optional<double> smallest(const PlannedDifference& planned, int episodes) {
  if (!isKnown(planned)) {
    return std::nullopt;
  }
  return planned.deviation ? smallestDifference(*planned.deviation, episodes)
                           : smallestRateDifference(*planned.discordant, episodes);
}

/// Smallest difference as a cell of the table.
std::string smallestText(const PlannedDifference& planned, int episodes) {
  const std::optional<double> least = smallest(planned, episodes);
  return least ? significant(*least) : isKnown(planned) ? "none" : "-";
}

/// Number of episodes that shows the wanted difference; none if none suffices, none is wanted or nothing is known.
std::optional<int> needed(const PlannedDifference& planned) {
  if (!planned.wanted) {
    return std::nullopt;
  }
  if (planned.deviation) {
    return episodesFor(*planned.deviation, *planned.wanted);
  }
  return *planned.wanted <= planned.discordant.value_or(0.0) ? episodesForRates(*planned.discordant, *planned.wanted)
                                                             : std::nullopt;
}

/// Why a number of episodes shows no difference of success rates: they differ by no more than this share.
std::string discordantText(const PlannedDifference& planned) {
  return "only one succeeds in " + significant(*planned.discordant) + " of all pairs";
}

/// "353 episodes", or why none suffice.
std::string episodesText(const PlannedDifference& planned) {
  if (!planned.deviation && *planned.wanted > *planned.discordant) {
    return "none suffice: " + discordantText(planned);
  }
  const std::optional<int> episodes = needed(planned);
  return episodes ? std::to_string(*episodes) + " episodes"
                  : "more than " + std::to_string(kMostEpisodes) + " episodes";
}

/// Number of episodes that shows the wanted difference, as text. If none is wanted: why `episodes` show no difference
/// of success rates; empty if they show one.
std::string neededText(const PlannedDifference& planned, const std::vector<int>& episodes) {
  if (!planned.wanted) {
    const bool all_show = !planned.discordant || std::all_of(episodes.begin(), episodes.end(),
                                                             [&](int count) { return smallest(planned, count); });
    return all_show ? "" : "(none: " + discordantText(planned) + ")";
  }
  if (!planned.deviation && !planned.discordant) {
    return "unknown: the pilot is too short";
  }
  return significant(*planned.wanted) + ": " + episodesText(planned);
}

/// Figures of planTable(): for each difference the smallest ones that are shown, by the numbers of episodes.
nlohmann::json planFigures(const PlanQuestions& questions, const RunResults& pilot,
                           const std::optional<RunResults>& other) {
  nlohmann::json differences = nlohmann::json::array();
  for (const PlannedDifference& planned : plannedDifferences(questions, pilot, other)) {
    nlohmann::json least = nlohmann::json::array();
    for (const int episodes : questions.episodes) {
      least.push_back(orNull(smallest(planned, episodes)));
    }
    differences.push_back({{"figure", planned.text},
                           {"smallest", least},
                           {"wanted", orNull(planned.wanted)},
                           {"episodes_needed", orNull(needed(planned))}});
  }
  return {{"episodes", questions.episodes}, {"differences", differences}};
}

/// Number of policies that show that a ranking is preserved; none if none suffice.
std::optional<int> policiesFor(double tau) {
  if (tau >= 1.0) {
    return kFewestPolicies;
  }
  return tau > 0.0 ? policiesForKendall(tau) : std::nullopt;
}

/// policiesFor() as a cell of the table, with the reason if none suffice.
std::string policiesText(double tau) {
  if (const std::optional<int> policies = policiesFor(tau)) {
    return std::to_string(*policies);
  }
  return std::isnan(tau) ? "none suffice: no pair of policies differs in both"
         : tau <= 0.0    ? "none suffice: the pilot's order is not preserved"
                         : "more than " + std::to_string(kMostPolicies);
}

/// Figures of policiesTable().
nlohmann::json policiesFigures(const Matrix& pilot) {
  nlohmann::json rankings = nlohmann::json::array();
  for (const MatrixRanking& ranking : pilot.rankings) {
    const double tau = ranking.comparison.kendall.value;
    rankings.push_back({{"here", pilot.simulators[ranking.reference].name},
                        {"there", pilot.simulators[ranking.test].name},
                        {"kendall", std::isnan(tau) ? nlohmann::json() : nlohmann::json(tau)},
                        {"policies_needed", orNull(policiesFor(tau))}});
  }
  return {{"rankings", rankings}};
}

void requirePositive(const std::string& name, const std::optional<double>& difference) {
  if (difference && !(*difference > 0.0)) {
    throw pusht::InvalidInput(name + " " + significant(*difference) + ": must be above 0");
  }
}

void requireNoQuestions(const PlanOptions& options) {
  const PlanQuestions& questions = options.questions;
  const bool asks_episodes = questions.episodes != PlanQuestions{}.episodes;
  if (!options.other.empty() || asks_episodes || questions.success || questions.position || questions.angle) {
    throw pusht::InvalidInput(
        "pilot " + options.pilot +
        ": is a sweep over policies; other, --episodes, --success, --position and --angle need a run");
  }
}

}  // namespace

CommandWork planCommand(CLI::App& app) {
  const auto options = std::make_shared<PlanOptions>();
  PlanQuestions& questions = options->questions;
  app.description("Says how small a difference a run can show, from how much the episodes of a finished run vary.");
  app.add_option("pilot", options->pilot,
                 "folder of a run; or of a sweep over policies, to plan how many a comparison of rankings takes")
      ->required()
      ->check(notEmpty());
  app.add_option("other", options->other, "folder of a second run over the same episodes, to plan a contrast")
      ->check(notEmpty());
  app.add_option("--episodes", questions.episodes, "numbers of episodes: N,N,...")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--success", questions.success, "a difference of success rates: how many episodes show it?")
      ->check(decimalReal());
  app.add_option("--position", questions.position, "[m] a difference of position divergences")->check(decimalReal());
  app.add_option("--angle", questions.angle, "[rad] a difference of angle divergences")->check(decimalReal());
  return [options](const CommandHost& host) { return plan(*options, host); };
}

int planMain(int argc, char** argv) { return runCommand("plan", planCommand, argc, argv); }

std::string planTable(const PlanQuestions& questions, const RunResults& pilot, const std::optional<RunResults>& other) {
  constexpr std::size_t kText = 44;    // characters
  constexpr std::size_t kColumn = 10;  // characters
  std::ostringstream table;
  table << padded("smallest difference shown in [episodes]", kText);
  for (const int episodes : questions.episodes) {
    table << padded(std::to_string(episodes), kColumn);
  }
  table << "\n";
  for (const PlannedDifference& planned : plannedDifferences(questions, pilot, other)) {
    table << padded(planned.text, kText);
    for (const int episodes : questions.episodes) {
      table << padded(smallestText(planned, episodes), kColumn);
    }
    table << neededText(planned, questions.episodes) << "\n";
  }
  table << "(found in 80 % of runs at 5 %, two-sided; spreads as in the " << pilot.episodes.size() << " episodes of "
        << pilot.folder.string() << ")\n";
  return table.str();
}

std::string policiesTable(const Matrix& pilot) {
  std::vector<std::vector<std::string>> rows = {{"here", "there", "Kendall's tau", "policies"}};
  for (const MatrixRanking& ranking : pilot.rankings) {
    const double tau = ranking.comparison.kendall.value;
    rows.push_back({pilot.simulators[ranking.reference].name, pilot.simulators[ranking.test].name,
                    std::isnan(tau) ? "none" : significant(tau), policiesText(tau)});
  }
  return aligned(rows) +
         "(so many policies show in 80 % of sweeps, at 5 %, that the ranking here is preserved there; tau as among "
         "the " +
         std::to_string(pilot.policies.size()) + " policies)\n";
}

nlohmann::json plan(const PlanOptions& options, const CommandHost& host) {
  if (std::filesystem::exists(std::filesystem::path(options.pilot) / kSweepFile)) {
    requireNoQuestions(options);
    const Matrix matrix = readMatrix(options.pilot, {}, [] { requireNotInterrupted(); });
    *host.out << policiesTable(matrix) << std::flush;
    return policiesFigures(matrix);
  }
  requirePositive("success", options.questions.success);
  requirePositive("position", options.questions.position);
  requirePositive("angle", options.questions.angle);
  const RunResults pilot = readResults(options.pilot);
  if (pilot.protocol.repeats > 1) {
    throw pusht::InvalidInput("pilot " + options.pilot + ": has " + std::to_string(pilot.protocol.repeats) +
                              " repeats of each start; must have one, because a plan counts independent episodes");
  }
  const bool asks_divergence = options.questions.position || options.questions.angle;
  if (pilot.protocol.alone && (options.other.empty() || asks_divergence)) {
    throw pusht::InvalidInput("pilot " + options.pilot +
                              ": has no engine; must stand beside a run of another policy, without --position and "
                              "--angle");
  }
  std::optional<RunResults> other;
  if (!options.other.empty()) {
    requireNotInterrupted();
    other = readResults(options.other);
    pairingOf(pilot, *other);
  }
  const std::string table = planTable(options.questions, pilot, other);
  requireNotInterrupted();
  *host.out << table << std::flush;
  return planFigures(options.questions, pilot, other);
}

}  // namespace sim2sim
